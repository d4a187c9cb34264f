#!/usr/bin/env python3
"""Controller that crashes at a set point of more than 5 rad/s."""

from student import Student, main


class Crash(Student):
    def law(self, error: float, dt: float) -> float:
        table = {0: 1.0, 1: 1.0, 2: 1.0, 3: 1.0, 4: 1.0, 5: 1.0}
        return super().law(error, dt) * table[int(abs(self.set_point))]


if __name__ == "__main__":
    main(Crash)
