#!/usr/bin/env python3
"""Details of the page, and rare faults, in one browser."""

import rospy
from test_page_layout import Layout  # noqa: F401
from test_page_over import BrokenBags, Over  # noqa: F401
from test_page_panels import Panels  # noqa: F401
from test_page_plots import Plots  # noqa: F401
from test_page_view import View  # noqa: F401

from nodekit.testing.running import rosrun

if __name__ == "__main__":
    rospy.init_node("test_page_details")
    rosrun("topic_scope", "page_details", "test_page_details")
