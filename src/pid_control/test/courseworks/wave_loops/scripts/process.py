#!/usr/bin/env python
"""Process node with callbacks that set globals, and a loop."""

import numpy as np
import rospy
from std_msgs.msg import Float32

signal_data = 0.0
time_data = 0.0


def callback(msg):
    global signal_data
    signal_data = msg.data


def callback_time(msg):
    global time_data
    time_data = msg.data


if __name__ == "__main__":
    rospy.init_node("process")
    rospy.Subscriber("signal", Float32, callback)
    rospy.Subscriber("time", Float32, callback_time)
    pub = rospy.Publisher("proc_signal", Float32, queue_size=10)
    angle = rospy.get_param("process_angle", np.pi / 2.0)
    offset = rospy.get_param("process_offset", 1.0)
    gain = rospy.get_param("process_amplitude", 0.5)
    amplitude = rospy.get_param("signal_amplitude", 1.0)
    omega = rospy.get_param("signal_omega", 1.0)
    rate = rospy.Rate(10)
    while not rospy.is_shutdown():
        cosine = amplitude * np.cos(omega * time_data)
        shifted = signal_data * np.cos(angle) + cosine * np.sin(angle)
        pub.publish(gain * shifted + offset)
        rate.sleep()
