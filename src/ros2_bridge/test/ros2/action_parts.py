"""Helpers of the tests of actions: servers and clients of either ROS."""

import pathlib
import time
from typing import Any, Dict, List, Optional

import both
from action_msgs.srv import CancelGoal
from builtin_interfaces.msg import Time
from rclpy.action import ActionClient
from rclpy.qos import QoSProfile
from unique_identifier_msgs.msg import UUID

from bot_controller_demo_msgs.action import GoTo
from nodekit.testing.processes import Process
from nodekit.testing.waiting import TIMEOUT_S, wait_until

HERE = pathlib.Path(__file__).parent
#: Outcomes of goals in the tests' servers.
SUCCEED, ABORT, REJECT, PEND, PERSIST = range(5)


def goal(key: str, seconds: float, what: int = SUCCEED) -> GoTo.Goal:
    """Return a goal as action_server1 takes it."""
    made = GoTo.Goal()
    made.target_pose.header.frame_id = key
    made.target_pose.pose.position.x = seconds
    made.target_pose.pose.position.y = float(what)
    return made


class Client2:
    """A ROS 2 client, and its received messages."""

    def __init__(self, ros: both.Both, name: str) -> None:
        many = QoSProfile(depth=1000)  # by default, rclpy's client keeps ten in a burst
        self._client = ActionClient(
            ros.node,
            GoTo,
            name,
            goal_service_qos_profile=many,
            result_service_qos_profile=many,
            cancel_service_qos_profile=many,
        )
        self.feedback: Dict[str, List[float]] = {}
        self.handles: Dict[str, Any] = {}
        self.results: Dict[str, Any] = {}
        wait_until(self._client.server_is_ready, lambda: f"no server of {name}")

    def send(self, key: str, seconds: float, what: int = SUCCEED) -> Any:
        """Send a goal; return the future that has the handle."""
        heard = self.feedback.setdefault(key, [])

        def hear(message: Any) -> None:
            heard.append(message.feedback.progress.distance)

        future = self._client.send_goal_async(goal(key, seconds, what), hear)
        future.add_done_callback(lambda done: self._begin(key, done.result()))
        return future

    def _begin(self, key: str, handle: Any) -> None:
        self.handles[key] = handle
        if handle.accepted:
            result = handle.get_result_async()
            result.add_done_callback(lambda done: self.results.update({key: done.result()}))

    def accepted(self, key: str) -> bool:
        """Wait for the answer to a goal."""
        wait_until(lambda: key in self.handles, lambda: f"no answer to {key}")
        return bool(self.handles[key].accepted)

    def end(self, key: str) -> int:
        """Wait for the result of a goal, which must be its own; return its status."""
        wait_until(lambda: key in self.results, lambda: f"no result of {key}")
        phase = self.results[key].result.progress.phase
        assert phase in (key, ""), (key, phase)
        return int(self.results[key].status)

    def state(self, key: str) -> int:
        """Return the latest state of a goal."""
        return int(self.handles[key].status)

    def close(self) -> None:
        """Go."""
        self._client.destroy()


def cancel(
    ros: both.Both,
    name: str,
    handle: Any = None,
    until: Optional[Time] = None,
    patience: float = TIMEOUT_S,
) -> Any:
    """Call the cancel service; return None if it does not answer."""
    request = CancelGoal.Request()
    request.goal_info.goal_id = handle.goal_id if handle is not None else UUID()
    request.goal_info.stamp = until or Time()
    client = ros.node.create_client(CancelGoal, f"{name}/_action/cancel_goal")
    future = client.call_async(request)
    deadline = time.monotonic() + patience
    wait_until(lambda: future.done() or time.monotonic() > deadline, lambda: "")
    ros.node.destroy_client(client)
    return future.result() if future.done() else None


class Server1(Process):
    """A server of ROS 1."""

    def __init__(self, name: str, node: str = "action_server1") -> None:
        super().__init__(str(HERE / "action_server1.py"), [name, f"__name:={node}"])

    def __enter__(self) -> "Server1":
        self.wait_for_log("serving")
        return self

    def __exit__(self, *_: Any) -> None:
        self.end()


class Client1(Process):
    """A client, by default of ROS 1, which executes command lines and prints its events."""

    def __init__(self, name: str, ros: str = "1") -> None:
        # Without ROS 1's packages, which hide those of ROS 2.
        path = {"PYTHONPATH": ""} if ros == "2" else {}
        super().__init__(str(HERE / f"action_client{ros}.py"), [name], path)

    def __enter__(self) -> "Client1":
        self.wait_for_log("connected")
        return self

    def __exit__(self, *_: Any) -> None:
        self.end()
        print("the client's log:", *self.logged(), sep="\n")

    def tell(self, line: str) -> None:
        """Execute a command line."""
        assert self.popen.stdin is not None
        self.popen.stdin.write(line + "\n")
        self.popen.stdin.flush()

    def feedback(self, key: str) -> List[float]:
        """Return the events of a goal."""
        lines = [line.split() for line in self.lines]
        return [float(line[2]) for line in lines if line[:2] == [key, "feedback"]]

    def ended(self, key: str) -> List[str]:
        """Return state, result and text of a goal, None while it is active."""
        lines = [line.split(" ", 3) for line in list(self.lines)]
        on_the_way = ("accepted", "feedback")
        ends = [line[1:] for line in lines if line[0] == key and line[1] not in on_the_way]
        assert len(ends) <= 1, ends
        return ends[0] if ends else []

    def end_of(self, key: str) -> str:
        """Wait for the end of a goal; return all that it says."""
        return " ".join(wait_until(lambda: self.ended(key), lambda: str(self.lines[-5:]))).strip()


class Server2(Process):
    """A server of ROS 2."""

    def __init__(self, name: str) -> None:
        # Without ROS 1's packages, which hide those of ROS 2.
        path = {"PYTHONPATH": ""}
        super().__init__(str(HERE / "action_server2.py"), [name], path)

    def __enter__(self) -> "Server2":
        self.wait_for_log("serving")
        return self

    def __exit__(self, *_: Any) -> None:
        if self.popen.poll() is None:
            self.end()
