#!/usr/bin/env python3
"""Process node as a class that answers each message."""

import math

import rospy
from sine_classes.msg import Wave
from std_msgs.msg import Float64


class Processor:
    def __init__(self):
        self.phase_shift = rospy.get_param("~phase_shift", 1.0)
        self.scale = rospy.get_param("~scale", 0.5)
        self.offset = rospy.get_param("~offset", 1.0)
        self.publisher = rospy.Publisher("processed", Float64, queue_size=1)
        rospy.Subscriber("wave", Wave, self.answer)

    def answer(self, wave):
        phase = 2.0 * math.pi * wave.frequency * wave.time_x + self.phase_shift
        shifted = wave.amplitude * math.sin(phase)
        self.publisher.publish(self.scale * shifted + self.offset)


if __name__ == "__main__":
    rospy.init_node("processor")
    Processor()
    rospy.spin()
