"""Send a robot to a point by the action go_to of ROS 2: go_to.py X Y [SECONDS].

X and Y are in m. After so many seconds, if they are given, the goal is cancelled.
"""

import sys
from typing import Optional

import rclpy
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.node import Node

from bot_controller_demo_msgs.action import GoTo

ENDS = {
    GoalStatus.STATUS_SUCCEEDED: "arrived",
    GoalStatus.STATUS_CANCELED: "cancelled",
    GoalStatus.STATUS_ABORTED: "given up",
}


class Traveller(Node):
    """Sends one goal, and prints what becomes of it."""

    def __init__(self) -> None:
        super().__init__("traveller")
        self._client = ActionClient(self, GoTo, "go_to")
        self._is_accepted = False
        self._last = 0.0

    def travel(self, x: float, y: float, seconds: Optional[float]) -> None:
        """Go there; at most for some seconds, if that is given."""
        self._client.wait_for_server()
        goal = GoTo.Goal()
        goal.target_pose.pose.position.x, goal.target_pose.pose.position.y = x, y
        sent = self._client.send_goal_async(goal, self._report)
        rclpy.spin_until_future_complete(self, sent)
        handle = sent.result()
        if not handle.accepted:
            print("rejected")
            return
        self._is_accepted = True
        print("accepted")
        result = handle.get_result_async()
        rclpy.spin_until_future_complete(self, result, timeout_sec=seconds)
        if not result.done():
            handle.cancel_goal_async()
            rclpy.spin_until_future_complete(self, result)
        print(ENDS[result.result().status])

    def _report(self, message: GoTo.Impl.FeedbackMessage) -> None:
        distance = message.feedback.progress.distance
        # Feedback comes by a topic, and may overtake the service's answer.
        if self._is_accepted and abs(distance - self._last) >= 0.1:
            self._last = distance
            print(f"{distance:.1f} m left")


def main() -> None:
    """Do what the command line says."""
    x, y, *rest = map(float, sys.argv[1:])
    rclpy.init()
    node = Traveller()
    node.travel(x, y, rest[0] if rest else None)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
