#!/usr/bin/env python3
"""Node with a server of actionlib/TestAction, separate or hosted: ``action_node.py hosted``.

A goal runs until it is cancelled. 1 stops immediately then, 2 never does.
"""

import sys
import time

from actionlib.msg import TestAction, TestFeedback, TestResult

from nodekit import Node, ServerGoalHandle, host, run


class Server:
    def __init__(self, node: Node) -> None:
        node.create_action_server("test", TestAction, self.execute)
        node.on_shutdown(lambda: print("the node ends", flush=True))

    def execute(self, goal: ServerGoalHandle) -> TestResult:
        goal.publish_feedback(TestFeedback(goal.request.goal))
        while goal.request.goal == 2 or not goal.is_cancel_requested:
            time.sleep(0.01)
        print("stopped", flush=True)
        goal.canceled()
        return TestResult(5)


if __name__ == "__main__":
    if "hosted" in sys.argv:
        host("process", [("server", "", Server)])
    else:
        run("server", Server)
