#!/usr/bin/env python3
"""Has the countdown count from _number:=3, for _seconds:=10 at most."""

import rospy
from actionlib.msg import TestAction, TestFeedback, TestGoal

from nodekit import (
    FloatParameter,
    GoalError,
    GoalFuture,
    IntParameter,
    Node,
    ParameterSet,
    abort,
    run,
)


class Settings(ParameterSet):
    number = IntParameter(3, help="where to begin")
    seconds = FloatParameter(10.0, minimum=0.1, unit="s", help="time after which to cancel")


class CountFrom:
    def __init__(self, node: Node) -> None:
        self.settings = node.declare_parameters(Settings).values
        client = node.create_action_client("countdown", TestAction)
        goal = TestGoal(self.settings.number)
        client.send_goal_async(goal, self.on_feedback).add_done_callback(self.on_answer)

    def on_feedback(self, feedback: TestFeedback) -> None:
        rospy.loginfo("%d", feedback.feedback)

    def on_answer(self, answer: GoalFuture) -> None:
        try:
            self.goal = answer.result()
        except GoalError as error:  # there is no server
            abort(error)
        else:
            self.goal.get_result_async(self.settings.seconds).add_done_callback(self.on_result)

    def on_result(self, result: GoalFuture) -> None:
        try:
            if result.exception():  # not in time
                self.goal.cancel_goal()
            end = self.goal.get_result(timeout=1.0)
            rospy.loginfo("%s: %s, %d left", end.status.name, end.text, end.result.result)
            rospy.signal_shutdown("done")
        except GoalError as error:
            abort(error)


if __name__ == "__main__":
    run("count_from", CountFrom)
