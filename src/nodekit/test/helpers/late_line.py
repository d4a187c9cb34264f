#!/usr/bin/env python3
"""A node that logs when its end has closed ``/rosout`` already, as any callback may."""

import rospy
import rospy.core

from nodekit import Node, run


def start(node: Node) -> None:
    """Log a line behind what closes all topics."""
    rospy.core.add_preshutdown_hook(lambda reason: rospy.logwarn("late"))
    print("started", flush=True)


if __name__ == "__main__":
    run("late_line", start)
