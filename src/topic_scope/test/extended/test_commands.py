#!/usr/bin/env python3
"""The commands plot_bag.py and mask.py."""

import rospy
from test_mask_live import MaskLive  # noqa: F401
from test_plot_bag import PlotBag  # noqa: F401

from nodekit.testing.running import rosrun

if __name__ == "__main__":
    rospy.init_node("test_commands")
    rosrun("topic_scope", "commands", "test_commands")
