#!/usr/bin/env python3
"""Signal generator in the style that the course teaches; usage: signal_generator.py [RECORD].

Parameters are read once at import and again for every message, the loop is paced by
rospy.Rate, and every message is logged. The record is the benchmark's addition.
"""

import numpy as np
import rospy

from basic_comms.msg import signal_msg
from ci.benchmark.record import Record

amplitude = rospy.get_param("/signalGen_Amplitude", 2.0)
frequency = rospy.get_param("/signalGen_Frequency", 2.0 * np.pi)

if __name__ == "__main__":
    publisher = rospy.Publisher("signal", signal_msg, queue_size=10)
    rospy.init_node("signal_generator")
    rate = rospy.Rate(rospy.get_param("~rate", 10.0))
    record = Record(rospy.myargv()[1]) if len(rospy.myargv()) > 1 else None
    message = signal_msg()
    start = rospy.get_time()
    try:
        while not rospy.is_shutdown():
            amplitude = rospy.get_param("/signalGen_Amplitude", 2.0)
            frequency = rospy.get_param("/signalGen_Frequency", 2.0 * np.pi)
            message.amplitude = amplitude
            message.frequency = frequency
            message.time_x = rospy.get_time() - start
            message.signal_y = amplitude * np.sin(frequency * message.time_x)
            rospy.loginfo(message)
            if record:
                record.add(message.signal_y)
            publisher.publish(message)
            rate.sleep()
    except rospy.ROSInterruptException:
        pass
