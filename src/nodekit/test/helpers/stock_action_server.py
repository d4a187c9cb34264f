#!/usr/bin/env python3
"""Server of stock actionlib, for actionlib/TestAction, with any number of parallel goals.

A goal's number decides its end: 0 succeeds immediately, 1 is aborted, 2 is rejected, 3 is pending
until it is cancelled, 4 runs until it is cancelled; others ignore cancellations. The result has the
goal's number, and so has the feedback that is sent when a goal is accepted.
"""

import actionlib
import rospy
from actionlib.msg import TestAction, TestFeedback, TestResult


def begin(handle: actionlib.ServerGoalHandle) -> None:
    number = handle.get_goal().goal
    if number == 2:
        handle.set_rejected(TestResult(number), "not this one")
    if number in (2, 3):
        return
    handle.set_accepted("on its way")
    handle.publish_feedback(TestFeedback(number))
    if number == 0:
        handle.set_succeeded(TestResult(number), "there")
    elif number == 1:
        handle.set_aborted(TestResult(number), "no way")


def cancel(handle: actionlib.ServerGoalHandle) -> None:
    if handle.get_goal().goal in (3, 4):
        handle.set_canceled(TestResult(handle.get_goal().goal), "cancelled")


if __name__ == "__main__":
    rospy.init_node("stock_action_server")
    server = actionlib.ActionServer("test", TestAction, begin, cancel, auto_start=False)
    server.start()
    print("up", flush=True)
    rospy.spin()
