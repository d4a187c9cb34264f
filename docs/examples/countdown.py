#!/usr/bin/env python3
"""Counts down from a goal's number, ten times a second."""

import time

from actionlib.msg import TestAction, TestFeedback, TestGoal, TestResult

from nodekit import GoalRejected, Node, ServerGoalHandle, run


class Countdown:
    def __init__(self, node: Node) -> None:
        node.create_action_server("countdown", TestAction, self.execute, self.decide)

    def decide(self, goal: TestGoal) -> bool:
        if goal.goal < 0:
            raise GoalRejected(f"{goal.goal}: must be at least 0")
        return True

    def execute(self, goal: ServerGoalHandle) -> TestResult:
        left = goal.request.goal
        while left and not goal.is_cancel_requested:
            goal.publish_feedback(TestFeedback(left))
            time.sleep(0.1)
            left -= 1
        if goal.is_cancel_requested:
            goal.canceled(text="stopped")
        else:
            goal.succeed(text="lift-off")
        return TestResult(left)


if __name__ == "__main__":
    run("countdown", Countdown)
