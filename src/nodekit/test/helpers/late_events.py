#!/usr/bin/env python3
"""Node with events during its end: a client hangs up, a line is logged."""

import time

import rospy
import rospy.core
from std_srvs.srv import Trigger, TriggerResponse

from nodekit import Node, run

#: For how long a client may hang up, s.
_ENDING_S = 1.0


def start(node: Node) -> None:
    """Offer a service, end slowly, and log a line behind what closes all topics."""
    node.create_service("~serve", Trigger, lambda request: TriggerResponse())
    node.on_shutdown(end_slowly)
    rospy.core.add_preshutdown_hook(lambda reason: rospy.logwarn("late"))


def end_slowly() -> None:
    """Tell that it ends, and take a while."""
    print("ending", flush=True)
    time.sleep(_ENDING_S)


if __name__ == "__main__":
    run("late_events", start)
