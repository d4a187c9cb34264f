#!/usr/bin/env python3
"""PID in the callback, with dt from the motor's times, D of the output, and back-calculation."""

import math

import rospy

from pid_control.msg import motor_input, motor_output, set_point

KP, KI, KD, TRACKING_S = 0.08, 1.4, 0.0005, 0.05


class Controller:
    def __init__(self) -> None:
        self.set_point = self.integral = 0.0
        self.last = None
        self.publisher = rospy.Publisher("motor_input", motor_input, queue_size=1)
        rospy.Subscriber("set_point", set_point, self.on_set_point)
        rospy.Subscriber("motor_output", motor_output, self.on_output)

    def on_set_point(self, message: set_point) -> None:
        if not math.isnan(message.setPoint):
            self.set_point = message.setPoint

    def on_output(self, message: motor_output) -> None:
        if math.isnan(message.output):
            return
        last, self.last = self.last, message
        if last is None or not 0.0 < message.time - last.time < 0.5:
            return  # the first one, or another motor
        dt = message.time - last.time
        error = self.set_point - message.output
        slope = (message.output - last.output) / dt
        wanted = KP * error + self.integral - KD * slope
        value = max(-1.0, min(1.0, wanted))
        self.integral += dt * (KI * error + (value - wanted) / TRACKING_S)
        self.publisher.publish(value, message.time)


rospy.init_node("controller")
keep = Controller()
rospy.spin()
