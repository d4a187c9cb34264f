#!/usr/bin/env python3
"""Sends a robot to the point _x:=0.6 _y:=0.0 by the action go_to."""

import rospy
from bot_controller_demo_msgs.msg import GoToAction, GoToFeedback, GoToGoal

from nodekit import FloatParameter, GoalError, GoalFuture, Node, ParameterSet, abort, run


class Settings(ParameterSet):
    x = FloatParameter(0.0, unit="m", help="where to go, in the frame of the odometry")
    y = FloatParameter(0.0, unit="m", help="its other coordinate")


class DriveTo:
    def __init__(self, node: Node) -> None:
        settings = node.declare_parameters(Settings).values
        client = node.create_action_client("go_to", GoToAction)
        goal = GoToGoal()
        goal.target_pose.pose.position.x = settings.x
        goal.target_pose.pose.position.y = settings.y
        goal.target_pose.pose.orientation.w = 1.0
        client.send_goal_async(goal, self.on_feedback).add_done_callback(self.on_answer)

    def on_feedback(self, feedback: GoToFeedback) -> None:
        rospy.loginfo_throttle(1.0, f"{feedback.progress.distance:.1f} m left")

    def on_answer(self, answer: GoalFuture) -> None:
        try:
            answer.result().get_result_async(120.0).add_done_callback(self.on_result)
        except GoalError as error:
            abort(error)

    def on_result(self, result: GoalFuture) -> None:
        try:
            rospy.loginfo("%s: %s", result.result().status.name, result.result().text)
            rospy.signal_shutdown("done")
        except GoalError as error:
            abort(error)


if __name__ == "__main__":
    run("drive_to", DriveTo)
