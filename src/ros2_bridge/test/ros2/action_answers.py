"""Runs the queries of ``ros2 action``, and records their output: see answers."""

import threading
from typing import Any, Callable, List, Tuple

from action_msgs.msg import GoalStatus
from action_parts import REJECT, goal
from rclpy.action import ActionClient
from rclpy.action.graph import (
    get_action_client_names_and_types_by_node,
    get_action_names_and_types,
    get_action_server_names_and_types_by_node,
)
from rclpy.node import Node

from bot_controller_demo_msgs.action import GoTo
from nodekit.testing.waiting import TIMEOUT_S, wait_until

#: The node with the action, and the action.
ROBOT, ACTION = "/robot", "/go_to"
_TYPE = "bot_controller_demo_msgs/action/GoTo"
#: Parts that differ between runs.
_CHANGING = ("distance", "heading_error", "stamp")
_STATES = {
    GoalStatus.STATUS_SUCCEEDED: "SUCCEEDED",
    GoalStatus.STATUS_CANCELED: "CANCELED",
    GoalStatus.STATUS_ABORTED: "ABORTED",
}


class ActionAnswers:
    """Asks for the actions that a node sees.

    :param node: spun by its owner
    :param nodes: returns the names of the nodes that are asked
    """

    def __init__(self, node: Node, nodes: Callable[[], List[str]]) -> None:
        self._node, self._nodes = node, nodes

    def commands(self) -> List[Tuple[str, Callable[[], List[str]]]]:
        """Return the words of each command, and the function that runs it."""
        pose = "{target_pose: {header: {frame_id: there}, pose: {position: {x: %g, y: %g}}}}"
        goals = (("--feedback ", 0.3, 0.0), ("", 0.1, 1.0), ("", 0.1, float(REJECT)))
        return [
            ("action list -t", self._list),
            (f"action info -t {ACTION}", self._info),
            *(
                (
                    f'action send_goal {shown}{ACTION} {_TYPE} "{pose % (x, y)}"',
                    lambda shown=shown, x=x, y=y: self._send(x, y, bool(shown)),
                )
                for shown, x, y in goals
            ),
            (f'action send_goal {ACTION} {_TYPE} "{pose % (60.0, 0.0)}" and Ctrl-C', self._break),
        ]

    def is_there(self) -> bool:
        """Return whether the action exists."""
        return ACTION in dict(get_action_names_and_types(self._node))

    def of_node(self, name: str) -> List[str]:
        """Return the part of ``node info`` that is about actions."""
        lines = []
        for title, ask in (
            ("Action Servers", get_action_server_names_and_types_by_node),
            ("Action Clients", get_action_client_names_and_types_by_node),
        ):
            lines.append(f"  {title}:")
            found = sorted(ask(self._node, name, "/"))
            lines += [f"    {action}: {', '.join(types)}" for action, types in found]
        return lines

    def _list(self) -> List[str]:
        found = sorted(get_action_names_and_types(self._node))
        return [f"{name} [{', '.join(types)}]" for name, types in found]

    def _info(self) -> List[str]:
        lines = [f"Action: {ACTION}"]
        for title, ask in (
            ("clients", get_action_client_names_and_types_by_node),
            ("servers", get_action_server_names_and_types_by_node),
        ):
            found = []
            for node in self._nodes():
                namespace, _, name = node.rpartition("/")
                types = dict(ask(self._node, name, namespace or "/"))
                found += [f"    {node} [{', '.join(types[ACTION])}]"] if ACTION in types else []
            lines += [f"Action {title}: {len(found)}", *found]
        return lines

    def _send(self, x: float, y: float, is_whole: bool) -> List[str]:
        client = ActionClient(self._node, GoTo, ACTION)
        fed: List[Any] = []
        came = threading.Event()

        def feed(message: Any) -> None:
            fed.append(message.feedback)
            came.set()

        assert client.wait_for_server(TIMEOUT_S)
        sent = goal("there", x, int(y))
        handle = _result(client.send_goal_async(sent, feed))
        lines = ["..."]
        if is_whole:
            lines = ["Waiting for an action server to become available..."]
            lines += ["Sending goal:", *_as_yaml(sent, 1)]
        if not handle.accepted:
            client.destroy()
            return [*lines, "Goal was rejected."]
        lines.append("Goal accepted with ID: ...")
        answer = _result(handle.get_result_async())

        def is_fed() -> bool:
            if not came.wait(1.0):  # a busy server has had no time for it: once more
                _result(_result(client.send_goal_async(sent, feed)).get_result_async())
            return came.is_set()

        if is_whole:  # once, for any number of repetitions
            wait_until(is_fed, lambda: "no feedback")
            lines += ["Feedback:", *_as_yaml(fed[-1], 1)]
        client.destroy()
        lines += ["Result:", *_as_yaml(answer.result, 1)]
        return [*lines, f"Goal finished with status: {_STATES[answer.status]}"]

    def _break(self) -> List[str]:
        client = ActionClient(self._node, GoTo, ACTION)
        assert client.wait_for_server(TIMEOUT_S)
        handle = _result(client.send_goal_async(goal("there", 60.0)))
        result = handle.get_result_async()
        lines = ["...", "Goal accepted with ID: ...", "Canceling goal..."]
        (cancelled,) = _result(handle.cancel_goal_async()).goals_canceling
        assert cancelled.goal_id == handle.goal_id
        assert _result(result).status == GoalStatus.STATUS_CANCELED
        client.destroy()
        return [*lines, "Goal canceled."]


def _result(future: Any) -> Any:
    wait_until(future.done, lambda: "no answer")
    return future.result()


def _as_yaml(message: Any, depth: int) -> List[str]:
    """Return the fields of a message, one per line."""
    lines = []
    for name in message.get_fields_and_field_types():
        value, before = getattr(message, name), "  " * depth + name + ":"
        if name in _CHANGING:
            lines.append(f"{before} ...")
        elif hasattr(value, "get_fields_and_field_types"):
            lines += [before, *_as_yaml(value, depth + 1)]
        else:
            lines.append(f"{before} {value!r}" if value == "" else f"{before} {value}")
    return lines
