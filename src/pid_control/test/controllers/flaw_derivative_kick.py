#!/usr/bin/env python3
"""Controller with a derivative of the error."""

from student import Student, main


class DerivativeKick(Student):
    kd, before = 0.0015, 0.0

    def law(self, error: float, dt: float) -> float:
        slope = (error - self.before) / dt if dt > 0.0 else 0.0
        self.before = error
        return max(-1.0, min(1.0, super().law(error, dt) + self.kd * slope))


if __name__ == "__main__":
    main(DerivativeKick)
