#!/usr/bin/env python3
"""Controller that keeps NaN in its integral."""

import math

from pid_control.msg import motor_output, set_point
from student import Student, main


class KeepsNan(Student):
    def on_output(self, message: motor_output) -> None:
        self.output, self.time = message.output, message.time

    def on_set_point(self, message: set_point) -> None:
        self.set_point = message.setPoint

    def law(self, error: float, dt: float) -> float:
        self.integral += error * dt
        if abs(self.integral) > 0.8:
            self.integral = math.copysign(0.8, self.integral)
        return max(-1.0, min(1.0, self.kp * error + self.ki * self.integral))


if __name__ == "__main__":
    main(KeepsNan)
