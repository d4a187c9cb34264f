"""Queries to the slave API of nodes, which are fakes."""

from types import SimpleNamespace
from typing import Any, Dict, List

import pytest

from topic_scope.graph import node_queries
from topic_scope.graph.node_queries import PAUSE_S, TIMEOUT_S, NodeQueries


class Nodes:
    """Nodes, their master and the time."""

    def __init__(self, monkeypatch: "pytest.MonkeyPatch") -> None:
        self.now = 100.0
        self.uris = {"/a": "http://a:1", "/b": "http://b:1"}
        self.replies: Dict[str, Any] = {uri: (1, "", [uri]) for uri in self.uris.values()}
        self.calls: List[str] = []
        clock = SimpleNamespace(monotonic=lambda: self.now)
        monkeypatch.setattr(node_queries, "time", clock)
        master = SimpleNamespace(lookup_node=self.uris.get)
        monkeypatch.setattr(node_queries, "MasterClient", lambda _caller: master)
        monkeypatch.setattr(node_queries.xmlrpc.client, "ServerProxy", self.proxy)
        self.queries = NodeQueries("/scope")

    def proxy(self, uri: str, transport: Any) -> Any:
        assert transport.make_connection("localhost:1").timeout == TIMEOUT_S
        return _Proxy(self, uri)

    def counts(self, *nodes: str) -> Dict[str, Any]:
        return {node: one[1] for node, one in self.queries.message_counts(nodes).items()}


class _Proxy:
    """Connection to one node."""

    def __init__(self, nodes: Nodes, uri: str) -> None:
        self._nodes, self._uri = nodes, uri

    def __enter__(self) -> "_Proxy":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def getBusStats(self, caller: str) -> Any:
        assert caller == "/scope"
        self._nodes.calls.append(self._uri)
        return self._nodes.replies[self._uri]

    getSubscriptions = getBusStats


@pytest.fixture
def nodes(monkeypatch: "pytest.MonkeyPatch") -> Nodes:
    return Nodes(monkeypatch)


def test_node_without_an_answer_pauses_and_is_looked_up_again(nodes: Nodes) -> None:
    assert nodes.counts("/a", "/b", "/c") == {"/a": ["http://a:1"], "/b": ["http://b:1"]}
    nodes.replies["http://a:1"] = (0, "shutting down", [])
    assert list(nodes.counts("/a", "/b")) == ["/b"]
    nodes.uris["/a"] = "http://a:2"  # it has restarted
    nodes.replies["http://a:2"] = (1, "", [2])
    nodes.calls.clear()
    assert list(nodes.counts("/a", "/b")) == ["/b"] and nodes.calls == ["http://b:1"]
    nodes.now += PAUSE_S
    assert nodes.counts("/a", "/b")["/a"] == [2]


def test_node_that_had_disappeared_does_not_pause(nodes: Nodes) -> None:
    nodes.replies["http://a:1"] = (-1, "no", [])
    assert nodes.counts("/a") == {}
    nodes.counts("/b")
    nodes.replies["http://a:1"] = (1, "", [3])
    assert nodes.counts("/a") == {"/a": [3]}


def test_type_is_that_of_the_first_subscriber_with_a_known_one(nodes: Nodes) -> None:
    known = ("geometry_msgs/Twist", "geometry_msgs/TwistStamped")
    nodes.replies["http://a:1"] = (1, "", [("/cmd", "*"), ("/other", known[1])])
    nodes.replies["http://b:1"] = (1, "", [("/cmd", known[0])])
    assert nodes.queries.subscribed_type("/cmd", ["/b", "/a", "/gone"], known) == known[0]
    assert nodes.queries.subscribed_type("/cmd", ["/a"], known) is None
