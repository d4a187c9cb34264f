#!/usr/bin/env python3
"""Controller with P alone."""

from student import Student, main


class Proportional(Student):
    kp, ki = 0.2, 0.0


if __name__ == "__main__":
    main(Proportional)
