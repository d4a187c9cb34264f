#!/usr/bin/env python3
"""A node that does nothing but import rospy and the messages: the floor of memory."""

import rospy
from std_msgs.msg import Float32, String  # noqa: F401

from basic_comms.msg import signal_msg  # noqa: F401

rospy.init_node("bare_node")
rospy.spin()
