#!/usr/bin/env python3
"""Process node that finds the cosine by the root, and its sign by the last value."""

import numpy as np
import rospy
from std_msgs.msg import Float64

last = 0.0


def heard(msg):
    global last
    amplitude = rospy.get_param("~Amplitude")
    x = np.clip(msg.data / amplitude, -1.0, 1.0)
    cosine = np.sqrt(1.0 - x**2) * (1.0 if x >= last else -1.0)
    last = x
    phi = np.radians(rospy.get_param("~Phase"))
    y = amplitude * (x * np.cos(phi) + cosine * np.sin(phi))
    pub.publish((y + rospy.get_param("~Offset")) * rospy.get_param("~Gain"))


rospy.init_node("process_node")
pub = rospy.Publisher(rospy.get_namespace() + "proc_signal", Float64, queue_size=10)
rospy.Subscriber(rospy.get_namespace() + "signal", Float64, heard)
rospy.spin()
