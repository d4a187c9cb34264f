"""Goals of actions, by the clients and servers of either ROS that the bridge's tests have."""

import collections
import subprocess
import sys
import threading
import time
from typing import DefaultDict, Dict, List

from .observers import wait_until
from .peer_programs import RCLPY, WORKSPACE, rclpy_environment
from .processes import PATIENCE_S, Session

_PARTS = WORKSPACE / "src" / "ros2_bridge" / "test" / "ros2"
#: What becomes of a goal of the tests' servers.
SUCCEED, ABORT = range(2)
#: longest wait for a server, s
CONNECTED_WITHIN = 40.0


def start(
    session: Session, what: str, ros: str, name: str, talk: bool = False
) -> "subprocess.Popen[bytes]":
    """Start a server or a client.

    :param what: ``server`` or ``client``
    :param ros: ``1`` or ``2``
    :param name: of the action
    :param talk: give it pipes for standard input and output
    """
    script = str(_PARTS / f"action_{what}{ros}.py")
    if ros == "2":
        return session.start([str(RCLPY), script, name], rclpy_environment(), talk)
    return session.start([sys.executable, script, name], None, talk)


class Asker:
    """A client that is told by lines what to do, and what it has said.

    :param ros: its own, ``1`` or ``2``
    :param name: of the action
    """

    def __init__(self, session: Session, ros: str, name: str) -> None:
        self._session, self._process = session, start(session, "client", ros, name, talk=True)
        self.is_connected = False
        #: When each goal was sent, s, and those that were to be cancelled.
        self.sent: Dict[str, float] = {}
        self.cancelled: List[str] = []
        #: By goal: how long it took until it was accepted, us; state and result of each end.
        self.accepted: Dict[str, float] = {}
        self.ends: DefaultDict[str, List[List[str]]] = collections.defaultdict(list)
        #: How long feedback took, us, and how much there was by goal; that for another goal.
        self.feedback: List[float] = []
        self.heard: DefaultDict[str, int] = collections.defaultdict(int)
        self.strange: List[str] = []
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._take(line.decode().split())

    def _take(self, words: List[str]) -> None:
        if words == ["connected"]:
            self.is_connected = True
            return
        key, what, *rest = words
        if what == "accepted":
            self.accepted[key] = float(rest[0])
        elif what == "feedback":
            self.feedback.append(float(rest[1]))
            self.heard[key] += 1
            if rest[2:] != [key]:
                self.strange.append(f"{key} has feedback of {rest[2:]}")
        else:
            self.ends[key].append(words[1:3])

    def wait_for_server(self) -> None:
        """Wait until it is connected.

        :raises TimeoutError: if it is not
        """
        wait_until(lambda: self.is_connected, CONNECTED_WITHIN, "server of the action")

    def send(self, key: str, seconds: float, what: int = SUCCEED) -> None:
        """Send a goal.

        :param key: its name, which its feedback and its result have too
        :param seconds: how long it takes, s
        :param what: becomes of it
        """
        self.sent[key] = time.monotonic()
        self._tell(f"send {key} {seconds} {what}")

    def cancel(self, key: str) -> None:
        """Cancel a goal."""
        self.cancelled.append(key)
        self._tell(f"cancel {key}")

    def _tell(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(line.encode() + b"\n")
        self._process.stdin.flush()

    def close(self) -> None:
        """End it: it ends where there are no more lines."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            pass
        self._session.stop(self._process)
        self._thread.join(PATIENCE_S)
