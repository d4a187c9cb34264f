#!/usr/bin/env python3
"""A loop at 5 Hz."""

from student import Student, main


class TooSeldom(Student):
    rate = 5.0


if __name__ == "__main__":
    main(TooSeldom)
