#!/usr/bin/env python3
"""The integral keeps growing while the output is limited."""

from student import Student, main


class Windup(Student):
    def law(self, error: float, dt: float) -> float:
        self.integral += error * dt
        return max(-1.0, min(1.0, self.kp * error + self.ki * self.integral))


if __name__ == "__main__":
    main(Windup)
