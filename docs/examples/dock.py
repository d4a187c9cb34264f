#!/usr/bin/env python3
"""Docks a robot, which is slow, while a timer and an emergency stop go on."""

import time

import rospy
from std_msgs.msg import Empty
from std_srvs.srv import Trigger, TriggerResponse

from nodekit import MultiThreadedExecutor, MutuallyExclusiveCallbackGroup, Node, run


class Dock:
    def __init__(self, node: Node) -> None:
        MultiThreadedExecutor(3).add_node(node)
        self.stopped = False
        node.create_service("dock", Trigger, self.dock, group=MutuallyExclusiveCallbackGroup())
        node.create_subscription(
            "stop", Empty, self.stop, group=MutuallyExclusiveCallbackGroup(urgent=True)
        )
        node.create_timer(2.0, self.report)

    def dock(self, request: Trigger) -> TriggerResponse:
        for _ in range(30):
            if self.stopped:
                return TriggerResponse(False, "stopped on the way")
            time.sleep(0.1)
        return TriggerResponse(True, "docked")

    def stop(self, message: Empty) -> None:
        self.stopped = True

    def report(self, elapsed: float) -> None:
        rospy.loginfo("alive")


if __name__ == "__main__":
    run("dock", Dock)
