#!/usr/bin/env python3
"""The input is not limited."""

from student import Student, main


class NoClamp(Student):
    kp = 0.4

    def law(self, error: float, dt: float) -> float:
        self.integral += error * dt
        return self.kp * error + self.ki * self.integral


if __name__ == "__main__":
    main(NoClamp)
