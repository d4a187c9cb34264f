#!/usr/bin/env python3
"""Node with callbacks that wait for an answer, or sleep in an executor's thread."""

import threading
import time

import rospy
from std_srvs.srv import Trigger, TriggerRequest

from nodekit import CallError, Group, MultiThreadedExecutor, Node, run


class Waiting:
    def __init__(self, node: Node) -> None:
        MultiThreadedExecutor(3).add_node(node)
        self.client = node.create_client("slow", Trigger)
        self.asked = False
        self.told = threading.Event()
        rospy.on_shutdown(lambda: self.told.wait(30.0))  # once its calls are cancelled
        node.create_timer(1.0, self.ask, group=Group())
        node.create_timer(1.0, lambda elapsed: time.sleep(600.0), group=Group())

    def ask(self, elapsed: float) -> None:
        if self.asked:
            return
        self.asked = True
        future = self.client.call_async(TriggerRequest(), 600.0)
        print("asked", flush=True)
        for answer in (future.result, lambda: self.client.call(TriggerRequest())):
            try:
                answer()
            except CallError as error:
                print(error, flush=True)
        self.told.set()


if __name__ == "__main__":
    run("waiting", Waiting)
