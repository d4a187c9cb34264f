"""Processes of action clients and servers in either ROS, from the bridge's tests."""

import collections
import contextlib
import subprocess
import sys
import threading
from typing import DefaultDict, Dict, List, Set

from .peer_programs import RCLPY, WORKSPACE, rclpy_environment
from .processes import PATIENCE_S, Session
from .recorder import wait_until

_PROGRAMS = WORKSPACE / "src" / "ros2_bridge" / "test" / "ros2"
#: Outcomes that a goal may request from the tests' servers.
SUCCEED, ABORT = range(2)
#: Longest wait for a server [s].
CONNECTED_WITHIN = 40.0


def start(
    session: Session, role: str, ros: str, name: str, has_pipes: bool = False
) -> "subprocess.Popen[bytes]":
    """Start a server or a client.

    :param role: ``server`` or ``client``
    :param ros: ``1`` or ``2``
    :param name: of the action
    :param has_pipes: whether its standard input and output are pipes
    """
    script = str(_PROGRAMS / f"action_{role}{ros}.py")
    if ros == "2":
        return session.start([str(RCLPY), script, name], rclpy_environment(), has_pipes)
    return session.start([sys.executable, script, name], None, has_pipes)


class ActionClient:
    """A client process, and its reports.

    :param ros: its ROS, ``1`` or ``2``
    :param name: of the action

    :ivar sent: the goals sent, and of these the cancelled ones
    :ivar accepted: time from each goal to its acceptance [us]
    :ivar ends: state and result of each end, by goal
    :ivar feedback: age of each feedback on arrival [us]
    :ivar heard: number of feedbacks, by goal
    :ivar strange: feedback that belongs to another goal
    """

    def __init__(self, session: Session, ros: str, name: str) -> None:
        self.ros = ros
        self.sent: Set[str] = set()
        self.cancelled: Set[str] = set()
        self.accepted: Dict[str, float] = {}
        self.ends: DefaultDict[str, List[List[str]]] = collections.defaultdict(list)
        self.feedback: List[float] = []
        self.heard: DefaultDict[str, int] = collections.defaultdict(int)
        self.strange: List[str] = []
        self._is_connected = False
        self._session, self._process = session, start(session, "client", ros, name, True)
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            key, *rest = line.decode().split()
            if key == "connected":
                self._is_connected = True
            elif rest[0] == "accepted":
                self.accepted[key] = float(rest[1])
            elif rest[0] == "feedback":
                self.feedback.append(float(rest[2]))
                self.heard[key] += 1
                if rest[3:] != [key]:
                    self.strange.append(f"{key} has feedback of {rest[3:]}")
            else:
                self.ends[key].append(rest[:2])

    def wait_for_server(self) -> None:
        """Wait until the client is connected.

        :raises TimeoutError: if it does not connect
        """
        wait_until(lambda: self._is_connected, CONNECTED_WITHIN, "server of the action")

    def send(self, key: str, seconds: float, outcome: int = SUCCEED) -> None:
        """Send a goal.

        :param key: its name, which its feedback and its result have too
        :param seconds: how long it takes [s]
        """
        self.sent.add(key)
        self._write(f"send {key} {seconds} {outcome}")

    def cancel(self, key: str) -> None:
        """Cancel a goal."""
        self.cancelled.add(key)
        self._write(f"cancel {key}")

    def _write(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(line.encode() + b"\n")
        self._process.stdin.flush()

    def close(self) -> None:
        """End the client, which ends with its input."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(PATIENCE_S)
        self._session.stop(self._process)
        self._thread.join(PATIENCE_S)
