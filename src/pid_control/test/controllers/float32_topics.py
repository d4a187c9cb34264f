#!/usr/bin/env python3
"""PI with std_msgs/Float32 on all topics."""

import rospy
from std_msgs.msg import Float32

KP, KI, PERIOD_S = 0.08, 1.5, 0.01


class Controller:
    def __init__(self) -> None:
        self.set_point = self.output = self.integral = 0.0
        self.publisher = rospy.Publisher("motor_input", Float32, queue_size=1)
        rospy.Subscriber("set_point", Float32, self.on_set_point)
        rospy.Subscriber("motor_output", Float32, self.on_output)

    def on_set_point(self, message: Float32) -> None:
        self.set_point = message.data

    def on_output(self, message: Float32) -> None:
        self.output = message.data

    def step(self) -> None:
        error = self.set_point - self.output
        self.integral = max(-1.0, min(1.0, self.integral + KI * PERIOD_S * error))
        self.publisher.publish(max(-1.0, min(1.0, KP * error + self.integral)))


rospy.init_node("controller")
controller, rate = Controller(), rospy.Rate(1.0 / PERIOD_S)
while not rospy.is_shutdown():
    controller.step()
    rate.sleep()
