"""Whether nodes run: what they say themselves on a topic such as ``~status``."""

import re
from functools import partial
from typing import Any, Callable, Collection, Dict, List, Mapping

import rospy
from std_msgs.msg import String

from topic_scope.graph.background import Background

_TYPE = "std_msgs/String"
#: What such topics are called: status, state, motor_state.
_NAME = re.compile(r"(.*_)?(status|state)\Z")
#: Longest word that is shown.
_LONGEST = 30


def topics_of(
    nodes: Collection[str], publishers: Collection[Any], types: Mapping[str, str]
) -> Dict[str, str]:
    """Return on which topic each node says how it is.

    :param nodes: names of the nodes
    :param publishers: topics and the nodes that publish them
    :param types: type of each topic
    """
    found: Dict[str, str] = {}
    for topic, owners in sorted(publishers):
        if types.get(topic) == _TYPE and _NAME.match(topic.rpartition("/")[2]):
            for node in owners:
                if owners == [node] and node in nodes:
                    found.setdefault(node, topic)
    return found


class Lamps:
    """Knows what nodes say of themselves; all methods belong to the thread of the web.

    :param background: where to wait for the master
    :param deliver: hands a function to the thread of the web
    :param tell: tells all pages
    """

    def __init__(
        self,
        background: Background,
        deliver: Callable[[Callable[[], None]], None],
        tell: Callable[..., None],
    ) -> None:
        self._background, self._deliver, self._tell = background, deliver, tell
        self._topics: Dict[str, str] = {}
        self._states: Dict[str, str] = {}
        self._subscribers: Dict[str, rospy.Subscriber] = {}

    def message(self) -> Dict[str, Any]:
        """Return the state of each node that tells one."""
        return {"type": "lamps", "nodes": dict(self._states)}

    def follow(self, topics: Dict[str, str]) -> None:
        """Listen to nodes.

        :param topics: on which topic each of them says how it is
        """
        gone = [node for node, topic in self._topics.items() if topics.get(node) != topic]
        self._topics = topics
        for node in gone:
            if self._states.pop(node, None) is not None:
                self._tell(self.message())
        if set(topics.values()) != set(self._subscribers):
            self._background.run("lamps", partial(self._adjust, list(topics.values())), _ignore)

    def _adjust(self, topics: List[str]) -> None:
        # The thread of the web looks at them meanwhile, so each change makes a new dict.
        for topic in set(self._subscribers) - set(topics):
            self._subscribers[topic].unregister()
            left = {key: one for key, one in self._subscribers.items() if key != topic}
            self._subscribers = left
        for topic in set(topics) - set(self._subscribers):
            # As it comes: a process hears a topic as one type, and a tap may hear this one.
            made = rospy.Subscriber(topic, rospy.AnyMsg, self._hear, topic)
            self._subscribers = {**self._subscribers, topic: made}

    def _hear(self, message: Any, topic: str) -> None:
        if message._connection_header["type"] == _TYPE:
            text = String().deserialize(message._buff).data
            self._deliver(partial(self._on_state, topic, text))

    def _on_state(self, topic: str, text: str) -> None:
        for node, told in self._topics.items():
            word = " ".join(text.split()[:1])[:_LONGEST]
            if told == topic and self._states.get(node) != word:
                self._states[node] = word
                self._tell(self.message())


def _ignore(_result: Any) -> None:
    """A master that does not answer is asked again with the next look at the graph."""
