#!/usr/bin/env python3
"""Controller that advertises motor_input, and sends nothing."""

from student import Student, main


class Mute(Student):
    def send(self, value: float) -> None:
        pass


if __name__ == "__main__":
    main(Mute)
