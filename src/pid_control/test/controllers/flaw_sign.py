#!/usr/bin/env python3
"""The error has the wrong sign."""

from student import Student, main


class WrongSign(Student):
    def law(self, error: float, dt: float) -> float:
        return super().law(-error, dt)


if __name__ == "__main__":
    main(WrongSign)
