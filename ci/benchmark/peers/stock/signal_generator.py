#!/usr/bin/env python3
"""Signal generator as one would write it with rospy; usage: signal_generator.py RECORD."""

import math

import rospy

from basic_comms.msg import signal_msg
from ci.benchmark.record import Record

if __name__ == "__main__":
    rospy.init_node("signal_generator")
    amplitude = rospy.get_param("~amplitude", 2.0)
    frequency = rospy.get_param("~frequency", 2.0 * math.pi)
    rate = rospy.Rate(rospy.get_param("~rate", 10.0))
    publisher = rospy.Publisher("signal", signal_msg, queue_size=10)
    record = Record(rospy.myargv()[1])
    start = rospy.get_time()
    try:
        while not rospy.is_shutdown():
            time_x = rospy.get_time() - start
            signal_y = amplitude * math.sin(frequency * time_x)
            record.add(signal_y)
            publisher.publish(signal_msg(amplitude, frequency, time_x, signal_y))
            rate.sleep()
    except rospy.ROSInterruptException:
        pass
