#!/usr/bin/env python3
"""Signal generator as a class with a timer, its own message, private parameters."""

import math

import rospy
from sine_classes.msg import Wave


class Source:
    def __init__(self):
        self.amplitude = rospy.get_param("~amplitude", 1.0)
        self.frequency = rospy.get_param("~frequency", 1.0)
        self.begin = rospy.get_time()
        self.publisher = rospy.Publisher("wave", Wave, queue_size=1)
        self.timer = rospy.Timer(rospy.Duration(1.0 / rospy.get_param("~rate", 20)), self.send)

    def send(self, event):
        now = rospy.get_time() - self.begin
        omega = 2.0 * math.pi * self.frequency
        level = self.amplitude * math.sin(omega * now)
        self.publisher.publish(Wave(self.amplitude, self.frequency, now, level))


if __name__ == "__main__":
    rospy.init_node("source")
    Source()
    rospy.spin()
