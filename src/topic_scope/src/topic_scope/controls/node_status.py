"""Status of nodes, as they publish it on a topic such as ``~status``."""

import re
from typing import Any, Callable, Collection, Dict, Mapping

from std_msgs.msg import String

from topic_scope.graph.worker import Worker
from topic_scope.sampling.raw_subscriptions import RawSubscriptions

#: Time between two updates [s].
PERIOD_S = 0.1
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


class NodeStatuses:
    """Knows what nodes say of themselves; all methods belong to the web thread.

    :param subscriptions: where what they say comes in
    :param worker: where to wait for the master
    :param send: sends a message to all pages
    """

    def __init__(
        self,
        subscriptions: RawSubscriptions,
        worker: Worker,
        send: Callable[..., None],
    ) -> None:
        self._subscriptions, self._worker, self._send = subscriptions, worker, send
        self._topics: Dict[str, str] = {}
        self._states: Dict[str, str] = {}

    def message(self) -> Dict[str, Any]:
        """Return the state of each node that tells one."""
        return {"type": "statuses", "nodes": dict(self._states)}

    def follow(self, topics: Dict[str, str]) -> None:
        """Follow what nodes say.

        :param topics: on which topic each of them says how it is
        """
        gone = [node for node, topic in self._topics.items() if topics.get(node) != topic]
        self._topics = topics
        known = len(self._states)
        for node in gone:
            self._states.pop(node, None)
        if len(self._states) < known:
            self._send(self.message())
        self._subscriptions.want(set(topics.values()))
        if self._subscriptions.is_to_adjust:
            self._worker.run("statuses", self._subscriptions.adjust, _ignore)

    def update(self) -> None:
        """Read what has come, and send it to pages; to be called every PERIOD_S."""
        before = dict(self._states)
        for topic, subscription in self._subscriptions.subscriptions().items():
            texts = [
                String().deserialize(batch.messages[-1]).data
                for batch in subscription.drain()
                if batch.header.get("type") == _TYPE
            ]
            for node in [node for node, told in self._topics.items() if told == topic and texts]:
                self._states[node] = " ".join(texts[-1].split()[:1])[:_LONGEST]
        if self._states != before:
            self._send(self.message())


def _ignore(_result: Any) -> None:
    """Skip a master that does not answer; the next poll of the graph asks it again."""
