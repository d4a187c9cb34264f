#!/usr/bin/env python3
"""Node that only imports rospy and the messages: the minimum of memory."""

import rospy
from std_msgs.msg import Float32, String  # noqa: F401

from basic_comms.msg import signal_msg  # noqa: F401

rospy.init_node("bare_node")
rospy.spin()
