#!/usr/bin/env python3
"""A node that talks to the master for as long as it starts, which it does for ever."""

import itertools

import rospy
from std_srvs.srv import Trigger, TriggerResponse

from nodekit import Node, run


def start(_node: Node) -> None:
    """Register services without end."""
    print("starting", flush=True)
    for number in itertools.count():
        service = rospy.Service(f"~{number}", Trigger, lambda request: TriggerResponse())
        service.shutdown()


if __name__ == "__main__":
    run("slow_start", start)
