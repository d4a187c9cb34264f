"""The graph of ROS 1 from the master's answers."""

from typing import Any, List

import pytest

from nodekit import MasterUnreachable
from ros2_bridge.ros1.graph import read_graph


class Master:
    """Answers as a master does, and remembers types of topics that are no more."""

    STATE = [
        [["/chatter", ["/talker", "/bridge"]], ["/own", ["/bridge"]]],
        [["/chatter", ["/listener"]]],
        [["/reset", ["/plant", "/observer"]], ["/bridge/x", ["/bridge"]]],
    ]

    def request(self, calls: List[Any]) -> List[Any]:
        answers = {
            ("getSystemState",): self.STATE,
            ("getPublishedTopics", ""): [["/chatter", "std_msgs/String"], ["/own", "*"]],
            ("getTopicTypes",): [["/chatter", "std_msgs/String"], ["/gone", "std_msgs/Int8"]],
            ("getPid",): 7,
        }
        return [(1, "", answers[call]) for call in calls]


def test_graph_of_other_nodes() -> None:
    client: Any = Master()
    graph = read_graph(client, {"/bridge"})
    assert graph.publishers == {"/chatter": {"/talker"}}
    assert graph.subscribers == {"/chatter": {"/listener"}}
    assert (graph.services, graph.master_pid) == ({"/reset": "/observer"}, 7)
    assert graph.nodes() == {"/talker", "/listener", "/observer"}


def test_the_age_of_the_master_does_not_matter() -> None:
    client: Any = Master()
    assert "/gone" not in read_graph(client, set()).types


def test_malformed_master_reply() -> None:
    client: Any = Master()
    client.STATE = 3
    with pytest.raises(MasterUnreachable, match="malformed reply of the master"):
        read_graph(client, set())
