#!/usr/bin/env python
"""Signal generator with two topics of numbers, and its parameters at the root."""

import numpy as np
import rospy
from std_msgs.msg import Float32

if __name__ == "__main__":
    signal_pub = rospy.Publisher("signal", Float32, queue_size=10)
    time_pub = rospy.Publisher("time", Float32, queue_size=10)
    rospy.init_node("signal_generator")
    amplitude = rospy.get_param("signal_amplitude", 1.0)
    omega = rospy.get_param("signal_omega", 1.0)
    rate = rospy.Rate(10)
    begin = rospy.get_time()
    while not rospy.is_shutdown():
        time = rospy.get_time() - begin
        signal = amplitude * np.sin(omega * time)
        rospy.loginfo("The signal value is: %f at a time %f", signal, time)
        time_pub.publish(time)
        signal_pub.publish(signal)
        rate.sleep()
