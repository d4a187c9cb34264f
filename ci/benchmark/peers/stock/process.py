#!/usr/bin/env python3
"""The process node as one would write it with rospy: scaled, shifted in phase, lifted."""

import math

import rospy
from std_msgs.msg import Float32

from basic_comms.msg import signal_msg

if __name__ == "__main__":
    rospy.init_node("process")
    scale = rospy.get_param("~amplitude_scale", 0.5)
    shift = rospy.get_param("~phase_shift", math.pi / 2.0)
    publisher = rospy.Publisher("proc_signal", Float32, queue_size=10)

    def answer(sample):
        """Answer a sample."""
        phase = sample.frequency * sample.time_x
        publisher.publish(scale * sample.amplitude * (math.sin(phase + shift) + 1.0))

    rospy.Subscriber("signal", signal_msg, answer, tcp_nodelay=True)
    rospy.spin()
