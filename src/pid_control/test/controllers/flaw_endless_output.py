#!/usr/bin/env python3
"""Controller that prints without end."""

import threading

from student import Student, main


def chatter() -> None:
    while True:
        print("error " * 1000)


if __name__ == "__main__":
    threading.Thread(target=chatter, daemon=True).start()
    main(Student)
