"""Teleoperation from pages: velocity commands (one page per robot) and PoseStamped goals."""

import math
import time
from functools import partial
from typing import Any, Callable, Dict, List, Optional, Tuple

import rospy
from geometry_msgs.msg import PoseStamped

from nodekit import NodeScope
from topic_scope.graph.worker import Worker
from topic_scope.graph.master_watch import GraphState
from topic_scope.graph.node_queries import NodeQueries
from topic_scope.page.open_page import Page
from topic_scope.protocol.requests import Drive, Goal
from topic_scope.robots import drive_session
from topic_scope.robots.dead_man import Velocity
from topic_scope.robots.drive_session import DriveSession

_GOAL = PoseStamped._type
#: Timeout for a subscriber of goals to connect [s].
_CONNECTING_S = 3.0
#: Time for a zero to be sent at shutdown [s]; a busy machine needs it.
_LAST_S = 0.5


class Driving:
    """Assignment of robots to the pages that drive them; used in the web thread only.

    :param node: node of the scope
    :param worker: runs calls that wait for nodes
    """

    def __init__(self, node: NodeScope, worker: Worker) -> None:
        self._name, self._worker = node.name, worker
        self._queries = NodeQueries(node.name)
        self._subscribers: Dict[str, List[str]] = {}
        self._types: Dict[str, str] = {}
        self._sessions: Dict[str, Tuple[Page, DriveSession]] = {}
        self._wanted: Dict[Page, str] = {}
        self._goals: Dict[str, rospy.Publisher] = {}
        self._is_over = False
        node.on_shutdown(self._stop_all)

    def on_state(self, state: GraphState) -> None:
        """Update the state of the graph."""
        subscribers = {topic: set(nodes) - {self._name} for topic, nodes in state.subscribers}
        self._subscribers = {topic: sorted(nodes) for topic, nodes in subscribers.items() if nodes}
        self._types = {topic: state.types.get(topic, "*") for topic in self._subscribers}

    def targets(self) -> Dict[str, Any]:
        """Return the topics of robots' commands and goals."""
        pairs = sorted(self._types.items())
        return {
            "type": "targets",
            "commands": [topic for topic, datatype in pairs if datatype in drive_session.TYPES],
            "goals": [topic for topic, datatype in pairs if datatype == _GOAL],
        }

    # --- Commands ----------------------------------------------------------------------------

    def steer(self, page: Page, topic: str) -> None:
        """Start a drive session for a page; ends the session of another page for the same robot.

        :param topic: topic of the robot's commands; empty to stop driving
        :raises ValueError: if the topic has no subscriber
        """
        if topic and self._wanted.get(page) == topic:
            return  # a second click before the reply
        self.leave(page)
        if not topic:
            return
        ask = self._asked(topic, drive_session.TYPES)
        then = partial(self._on_session, page, topic)
        if not self._worker.run(("steer", topic), partial(_make, topic, ask), then):
            raise ValueError(f"the subscribers of {topic} have not answered yet")
        self._wanted[page] = topic

    def _on_session(self, page: Page, topic: str, made: Any) -> None:
        is_wanted = (
            self._wanted.get(page) == topic
        )  # the page may have left, or chosen another robot
        if is_wanted:
            del self._wanted[page]
        if isinstance(made, Exception):
            page.put_once({"type": "error", "text": str(made)})
        elif not is_wanted:
            made.close()
        else:
            former, _ = self._sessions.get(topic, (page, None))
            self.leave(former)
            if former is not page:
                former.put_once({"type": "error", "text": f"another page drives on {topic} now"})
            self._sessions[topic] = (page, made)
            if self._is_over:  # created after all sessions were closed
                made.close()
            page.put(_steering(topic, made.datatype))

    def leave(self, page: Page) -> None:
        """End all drive sessions of a page; its robots stop."""
        self._wanted.pop(page, None)
        for topic in [topic for topic, (owner, _) in self._sessions.items() if owner is page]:
            self._sessions.pop(topic)[1].close()
            page.put(_steering("", ""))

    def drive(self, page: Page, request: Drive) -> None:
        """Move the robot that a page drives.

        :raises ValueError: if the page drives no robot, or the command arrived too late
        """
        velocity = Velocity(request.speed, request.turn)
        sessions = [one for owner, one in self._sessions.values() if owner is page]
        if not sessions and not request.is_stop:
            raise ValueError("this page does not drive a robot: take the wheel first")
        if not all([one.drive(velocity, request.sent) for one in sessions]):
            raise ValueError(
                "a command arrived too late and was ignored: the link is slow; "
                "if this continues, take the wheel again"
            )

    def _stop_all(self) -> None:
        # Permanent: pages send commands until the process ends.
        self._is_over = True
        if any([one.close() for _, one in list(self._sessions.values())]):
            time.sleep(_LAST_S)

    # --- Goals -------------------------------------------------------------------------------

    def send(self, page: Page, request: Goal) -> None:
        """Publish a goal.

        :raises ValueError: if the topic has no subscriber
        """
        ask = self._asked(request.topic, (_GOAL,))
        work = partial(self._send, request, ask)
        then = partial(_on_sent, page, request)
        if not self._worker.run(("goal", request.topic), work, then):
            raise ValueError(f"an earlier goal for {request.topic} has not been sent yet")

    def _send(self, request: Goal, ask: Callable[[], Optional[str]]) -> None:
        topic = request.topic
        if ask() is None:
            raise ValueError(f"no subscriber of {topic} takes a PoseStamped")
        if topic not in self._goals:
            self._goals[topic] = rospy.Publisher(topic, PoseStamped, queue_size=1)
        publisher, end = self._goals[topic], time.monotonic() + _CONNECTING_S
        while not publisher.get_num_connections():
            if time.monotonic() > end:
                raise ValueError(
                    f"no subscriber of {topic} has connected within {_CONNECTING_S:g} s"
                )
            time.sleep(0.01)
        message = PoseStamped()
        message.header.stamp, message.header.frame_id = rospy.Time.now(), request.frame
        pose = message.pose
        pose.position.x, pose.position.y = request.x, request.y
        pose.orientation.z = math.sin(request.heading / 2.0)
        pose.orientation.w = math.cos(request.heading / 2.0)
        publisher.publish(message)

    def rest(self) -> None:
        """Unregister all publishers of goals, when no page shows robots."""
        for topic in list(self._goals):
            end = self._goals.pop(topic).unregister
            self._worker.run(("goal", topic), end, lambda _: None)

    # --- Both --------------------------------------------------------------------------------

    def _asked(self, topic: str, known: Any) -> Callable[[], Optional[str]]:
        """Return a job that queries the type of a topic's subscribers.

        :raises ValueError: if the topic has no subscriber
        """
        nodes = self._subscribers.get(topic)
        if not nodes:
            raise ValueError(f"no subscriber of {topic}")
        return partial(self._queries.subscribed_type, topic, nodes, known)


def _make(topic: str, ask: Callable[[], Optional[str]]) -> DriveSession:
    datatype = ask()
    if datatype is None:
        raise ValueError(f"no subscriber of {topic} takes a Twist or a TwistStamped")
    return DriveSession(topic, datatype)


def _steering(topic: str, datatype: str) -> Dict[str, Any]:
    return {"type": "steering", "topic": topic, "datatype": datatype}


def _on_sent(page: Page, request: Goal, result: Any) -> None:
    if isinstance(result, Exception):
        page.put_once({"type": "error", "text": str(result)})
    else:
        page.put({"type": "sent", "topic": request.topic})
