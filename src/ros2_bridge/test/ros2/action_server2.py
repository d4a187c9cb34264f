"""ROS 2 action server for the tests, with any number of concurrent goals.

A goal is a pose: x is its duration [s], y its outcome: it succeeds (0), or is aborted (1), it is
rejected (2), or cannot be cancelled (4). The result has the goal's frame_id, and so has the
feedback, with the remaining time and the time of sending [s].
"""

import contextlib
import sys
import time
from typing import Any, Dict, List

import rclpy
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future

from bot_controller_demo_msgs.action import GoTo

SUCCEED, ABORT, REJECT, _, PERSIST = range(5)


class Server:
    """Serves the action of this name; its node is to be spun."""

    def __init__(self, node: Node, name: str) -> None:
        self._goals: List[Any] = []
        self._due: Dict[bytes, Any] = {}
        many = QoSProfile(depth=1000)
        self._server = ActionServer(
            node,
            GoTo,
            name,
            execute_callback=self._end,
            goal_callback=self._validate,
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
            goal_service_qos_profile=many,
            result_service_qos_profile=many,
            cancel_service_qos_profile=many,
        )
        node.create_timer(0.05, self._step)

    @staticmethod
    def _what(request: GoTo.Goal) -> float:
        return request.target_pose.pose.position.y

    def _validate(self, request: GoTo.Goal) -> GoalResponse:
        is_good = self._what(request) != REJECT
        return GoalResponse.ACCEPT if is_good else GoalResponse.REJECT

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        is_good = self._what(handle.request) != PERSIST
        return CancelResponse.ACCEPT if is_good else CancelResponse.REJECT

    def _begin(self, handle: ServerGoalHandle) -> None:
        self._due[bytes(handle.goal_id.uuid)] = Future()
        self._goals.append((handle, time.monotonic()))
        handle.execute()

    def _step(self) -> None:
        for entry in list(self._goals):
            handle, began = entry
            left = handle.request.target_pose.pose.position.x - (time.monotonic() - began)
            if left > 0.0 and not handle.is_cancel_requested:
                feedback = GoTo.Feedback()
                feedback.progress.distance = left
                feedback.progress.phase = handle.request.target_pose.header.frame_id
                feedback.progress.heading_error = time.monotonic()
                handle.publish_feedback(feedback)
            else:
                self._goals.remove(entry)
                self._due[bytes(handle.goal_id.uuid)].set_result(None)

    async def _end(self, handle: ServerGoalHandle) -> GoTo.Result:
        await self._due[bytes(handle.goal_id.uuid)]
        result = GoTo.Result()
        result.progress.phase = handle.request.target_pose.header.frame_id
        if handle.is_cancel_requested:
            handle.canceled()
        elif self._what(handle.request) == ABORT:
            handle.abort()
        else:
            handle.succeed()
        return result


if __name__ == "__main__":
    rclpy.init()
    own = Node("action_server2")
    server = Server(own, sys.argv[1])
    print("serving", flush=True)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(own)
    own.destroy_node()
    rclpy.try_shutdown()
