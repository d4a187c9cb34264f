"""A client of ROS 2 that obeys the lines of action_client1, and prints the same."""

import contextlib
import sys
import threading
import time
from typing import Any, Dict

import rclpy
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile

from bot_controller_demo_msgs.action import GoTo

NAMES = {
    getattr(GoalStatus, name): name[len("STATUS_") :]
    for name in ("STATUS_SUCCEEDED", "STATUS_CANCELED", "STATUS_ABORTED", "STATUS_UNKNOWN")
}


def say(line: str) -> None:
    """Print a complete line: several threads print."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


class Client:
    """A client of the action of this name; its node is to be spun."""

    def __init__(self, node: Node, name: str) -> None:
        many = QoSProfile(depth=1000)
        self._client = ActionClient(
            node,
            GoTo,
            name,
            goal_service_qos_profile=many,
            result_service_qos_profile=many,
            cancel_service_qos_profile=many,
        )
        self._accepted: Dict[str, Any] = {}

    def connect(self) -> None:
        """Wait for the server."""
        assert self._client.wait_for_server(20.0)
        say("connected")

    def obey(self, what: str, key: str = "", x: str = "0", y: str = "0") -> None:
        """Execute a command line."""
        if what == "send":
            goal = GoTo.Goal()
            goal.target_pose.header.frame_id = key
            goal.target_pose.pose.position.x = float(x)
            goal.target_pose.pose.position.y = float(y)
            began = time.monotonic()
            self._accepted[key] = future = self._client.send_goal_async(
                goal, lambda message: self._feed(key, message.feedback.progress)
            )
            future.add_done_callback(lambda done: self._begin(key, began, done.result()))
        elif what == "cancel":
            future = self._accepted[key]
            future.add_done_callback(lambda done: done.result().cancel_goal_async())

    def _begin(self, key: str, began: float, handle: Any) -> None:
        if not handle.accepted:
            say(f"{key} REJECTED - ")
            return
        say(f"{key} accepted {1e6 * (time.monotonic() - began):.0f}")
        handle.get_result_async().add_done_callback(lambda done: self._end(key, done.result()))

    def _end(self, key: str, answer: Any) -> None:
        say(f"{key} {NAMES[answer.status]} {answer.result.progress.phase or '-'} ")

    def _feed(self, key: str, progress: Any) -> None:
        took = 1e6 * (time.monotonic() - progress.heading_error)
        say(f"{key} feedback {progress.distance} {took:.0f} {progress.phase}")


def main() -> None:
    """Obey until there are no more lines."""
    rclpy.init()
    node = Node("action_client2")
    client = Client(node, sys.argv[1])

    def spin() -> None:
        with contextlib.suppress(ExternalShutdownException):
            rclpy.spin(node)

    spinning = threading.Thread(target=spin, daemon=True)
    spinning.start()
    client.connect()
    for line in sys.stdin:
        client.obey(*line.split())
    rclpy.shutdown()
    spinning.join(5.0)


if __name__ == "__main__":
    main()
