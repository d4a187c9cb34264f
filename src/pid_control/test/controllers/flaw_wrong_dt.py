#!/usr/bin/env python3
"""Controller that integrates with a constant 1/1000 s in a loop at 100 Hz."""

from student import Student, main


class WrongInterval(Student):
    ki = 12.0

    def law(self, error: float, dt: float) -> float:
        return super().law(error, 0.001)


if __name__ == "__main__":
    main(WrongInterval)
