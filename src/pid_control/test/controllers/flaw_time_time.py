#!/usr/bin/env python3
"""Controller with dt from time.time()."""

import time

from student import Student, main


class MachineClock(Student):
    def now(self) -> float:
        return time.time()


if __name__ == "__main__":
    main(MachineClock)
