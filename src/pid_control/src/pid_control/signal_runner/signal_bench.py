"""Test bench of a student's two nodes: publishes /clock, and records numbers in their messages."""

import contextlib
import functools
import threading
import time
import xmlrpc.client
from typing import Any, Dict, List, Mapping, Optional, Set, Tuple

import rosgraph
import rospy
from rosgraph_msgs.msg import Clock

from nodekit import init_node
from pid_control.programs.node_queries import NodeTopics, ask_links, ask_topics
from pid_control.programs.package_messages import class_of
from pid_control.signal_judging.channels import Channel
from pid_control.signal_runner.message_numbers import numbers_in

#: Name of the node.
NAME = "judge"
_OWN_TOPICS = ("/rosout", "/rosout_agg", "/clock")


class SignalBench:
    """Node that publishes ``/clock`` and subscribes to the topics of a student's nodes.

    Create it once per process, after ROS_MASTER_URI is set.
    """

    def __init__(self) -> None:
        self._classes: Dict[str, Any] = {}
        self._is_simulated = True
        self._node = init_node(NAME)
        self._lock = threading.Lock()
        self._clock = self._node.create_publisher("/clock", Clock)
        self._node.start()
        self._scope = self._node.create_scope()
        self._messages: Dict[str, List[Tuple[float, Dict[str, float]]]] = {}
        self._subscriptions: Dict[str, Any] = {}
        self._count = 0
        self._now = 0.0

    def close(self) -> None:
        """Shut the node down for good, while the master still runs."""
        rospy.signal_shutdown("the judgement is complete")

    def use_classes(self, classes: Mapping[str, Any]) -> None:
        """Use the message classes of a package, by type, for later subscriptions."""
        self._classes = dict(classes)

    def use_clock(self, is_simulated: bool) -> None:
        """Use a clock from now on.

        :param is_simulated: True to publish the clock, False to use the machine's
        """
        self._is_simulated = is_simulated

    def set_clock(self, now: float) -> None:
        """Set the time [s]; publish it if it is simulated."""
        self._now = now
        if self._is_simulated:
            self._clock.publish(Clock(rospy.Time.from_sec(now)))

    def clock_listeners(self) -> int:
        """Return the number of nodes that are connected to the clock."""
        return int(self._clock.get_num_connections())

    def listen(self, types: Mapping[str, str]) -> None:
        """Record the messages of these topics from now on, in place of the previous ones.

        :param types: type of each topic
        :raises MessageTypeError: if a type is missing
        """
        self._scope.close()
        self._scope = self._node.create_scope()
        self._subscriptions.clear()
        with self._lock:
            self._messages = {topic: [] for topic in types}
        for topic, msg_type in types.items():
            message_class = class_of(topic, msg_type, self._classes)
            on_message = functools.partial(self._on_message, topic)
            self._subscriptions[topic] = self._scope.create_subscription(
                topic, message_class, on_message
            )

    def unheard(self) -> List[str]:
        """Return the subscribed topics without a connection."""
        return [name for name, one in self._subscriptions.items() if not one.get_num_connections()]

    def pop_count(self) -> int:
        """Return the number of messages since the previous call."""
        with self._lock:
            count, self._count = self._count, 0
        return count

    def channels(self, topic: str) -> List[Channel]:
        """Return the channels of a topic."""
        with self._lock:
            messages = list(self._messages.get(topic, ()))
        fields: Dict[str, Tuple[List[float], List[float]]] = {}
        for arrival, numbers in messages:
            for field, value in numbers.items():
                times, values = fields.setdefault(field, ([], []))
                times.append(arrival)
                values.append(value)
        return [Channel(topic, field, *series) for field, series in fields.items()]

    def topics_of(self, node: str) -> Optional[NodeTopics]:
        """Return the topics of a node except /rosout and /clock; None until it answers."""
        uri = self._uri(node)
        if uri is None:
            return None
        try:
            found = ask_topics(NAME, uri)
        except Exception:  # of any type: a student's node may reply anything
            return None
        chosen = [
            {topic: msg_type for topic, msg_type in one.items() if topic not in _OWN_TOPICS}
            for one in found
        ]
        return NodeTopics(chosen[0], chosen[1])

    def links_of(self, node: str) -> Set[str]:
        """Return the topics that a node receives over a connection."""
        uri = self._uri(node)
        if uri is None:
            return set()
        try:
            return ask_links(NAME, uri)
        except Exception:  # of any type: a student's node may reply anything
            return set()

    def _uri(self, node: str) -> Optional[str]:
        with contextlib.suppress(OSError, rosgraph.MasterException, xmlrpc.client.Error):
            return str(rosgraph.Master(NAME).lookupNode(node))
        return None

    def _on_message(self, topic: str, message: Any) -> None:
        arrival = self._now if self._is_simulated else time.monotonic()
        numbers = numbers_in(message)
        with self._lock:
            self._count += 1
            if topic in self._messages:
                self._messages[topic].append((arrival, numbers))
