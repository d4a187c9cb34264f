#! /usr/bin/python3
"""Signal generator in one function, with parameters from arguments of its launch file."""

import numpy as np
import rospy
from std_msgs.msg import Float64

rospy.init_node("sig_gen")
A, f = rospy.get_param("~Amplitude"), rospy.get_param("~Frequency")
out = rospy.Publisher(rospy.get_namespace() + "signal", Float64, queue_size=10)
rate = rospy.Rate(50)
t = 0.0
while not rospy.is_shutdown():
    out.publish(A * np.sin(f * t))
    t += 0.02
    rate.sleep()
