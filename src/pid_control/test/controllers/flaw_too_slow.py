#!/usr/bin/env python3
"""Controller with loop iterations longer than their period."""

import time

from student import Student, main


class TooSlow(Student):
    def law(self, error: float, dt: float) -> float:
        end = time.thread_time() + 0.03
        while time.thread_time() < end:
            pass
        return super().law(error, dt)


if __name__ == "__main__":
    main(TooSlow)
