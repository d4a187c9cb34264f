#!/usr/bin/env python3
"""Details of messages and requests of pages, and start and end of the scope."""

import rospy
from test_scope_controls import Controls  # noqa: F401
from test_scope_guards import Guards, ReadOnly  # noqa: F401
from test_scope_life import Life  # noqa: F401
from test_scope_robots import DeadMan, Feed  # noqa: F401
from test_scope_signals import Signals  # noqa: F401

from nodekit.testing.running import rosrun

if __name__ == "__main__":
    rospy.init_node("test_scope_details")
    rosrun("topic_scope", "scope_details", "test_scope_details")
