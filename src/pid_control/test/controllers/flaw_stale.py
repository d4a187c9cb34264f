#!/usr/bin/env python3
"""Controller that loses the output in a local variable: the statement global is missing."""

from pid_control.msg import motor_output
from student import Student, main


class Stale(Student):
    def on_output(self, message: motor_output) -> None:
        output = message.output  # noqa: F841


if __name__ == "__main__":
    main(Stale)
