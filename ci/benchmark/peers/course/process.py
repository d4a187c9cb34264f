#!/usr/bin/env python3
"""The process node in the style that the course teaches.

A callback leaves the last message in a global; a loop at 10 Hz reads the parameters, computes
and publishes, and logs every message.
"""

import numpy as np
import rospy
from std_msgs.msg import Float32

from basic_comms.msg import signal_msg

scale = rospy.get_param("/process_Scale", 0.5)
shift = rospy.get_param("/process_Shift", np.pi / 2.0)
offset = rospy.get_param("/process_Offset", 0.0)
latest = signal_msg()


def callback(message):
    """Keep the message for the loop."""
    global latest
    latest = message


if __name__ == "__main__":
    rospy.init_node("process")
    rate = rospy.Rate(10)
    rospy.Subscriber("signal", signal_msg, callback)
    publisher = rospy.Publisher("proc_signal", Float32, queue_size=10)
    try:
        while not rospy.is_shutdown():
            scale = rospy.get_param("/process_Scale", 0.5)
            shift = rospy.get_param("/process_Shift", np.pi / 2.0)
            offset = rospy.get_param("/process_Offset", 0.0)
            sample = latest
            x = sample.signal_y / sample.amplitude if sample.amplitude else 0.0
            shifted = x * np.cos(shift) + np.sqrt(max(0.0, 1.0 - x * x)) * np.sin(shift)
            output = scale * sample.amplitude * shifted + offset
            rospy.loginfo(output)
            publisher.publish(output)
            rate.sleep()
    except rospy.ROSInterruptException:
        pass
