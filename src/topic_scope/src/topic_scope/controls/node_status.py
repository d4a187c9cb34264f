"""Status of nodes, from topics such as ``~status``."""

import re
from typing import Any, Callable, Collection, Dict, Mapping

from std_msgs.msg import String

from topic_scope.graph.worker import Worker
from topic_scope.sampling.raw_subscriptions import RawSubscriptions

#: Update period [s].
PERIOD_S = 0.1
_TYPE = "std_msgs/String"
#: Last part of the names of such topics: status, state, motor_state.
_NAME = re.compile(r"(.*_)?(status|state)\Z")
#: Longest word to show.
_LONGEST = 30


def topics_of(
    nodes: Collection[str], publishers: Collection[Any], types: Mapping[str, str]
) -> Dict[str, str]:
    """Return the status topic of each node.

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
    """Statuses of nodes; all methods are for the web thread.

    :param subscriptions: subscriptions to the status topics
    :param worker: worker that waits for the master
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
        """Return the status of each node that publishes one."""
        return {"type": "statuses", "nodes": dict(self._states)}

    def follow(self, topics: Dict[str, str]) -> None:
        """Set the status topics.

        :param topics: status topic of each node
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
        """Read new statuses, and send them to pages; to be called every PERIOD_S."""
        before = dict(self._states)
        for topic, subscription in self._subscriptions.subscriptions().items():
            texts = [
                String().deserialize(batch.messages[-1]).data
                for batch in subscription.drain()
                if batch.header.get("type") == _TYPE
            ]
            for node in [node for node, name in self._topics.items() if name == topic and texts]:
                self._states[node] = " ".join(texts[-1].split()[:1])[:_LONGEST]
        if self._states != before:
            self._send(self.message())


def _ignore(_result: Any) -> None:
    """Ignore an unreachable master; the next poll of the graph retries."""
