"""Graph message of pages, and rates from counts."""

from typing import Any, Dict, List, Set
from unittest import mock

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_parameter_sender import SlowWorker

from topic_scope.graph import graph_feed
from topic_scope.graph.graph_feed import Rates, graph_message
from topic_scope.graph.master_watch import GraphState

STATE = GraphState(
    publishers=[("/signal", ["/gen"]), ("/rosout", ["/gen", "/proc"]), ("/lone", ["/gen", "/b"])],
    subscribers=[
        ("/signal", ["/proc", "/scope", "/c"]),
        ("/rosout", ["/rosout"]),
        ("/wanted", ["/c"]),
    ],
    services=[("/gen/reset", ["/gen"]), ("/quiet/reset", ["/quiet"])],
    types={"/signal": "a/B", "/rosout": "rosgraph_msgs/Log"},
)


def counts(topic: str, *connections: tuple) -> list:
    return [[[topic, 0, [[number, 0, count, 0] for number, count in connections]]], [], []]


def test_the_log_and_the_scope_itself_are_left_out() -> None:
    graph = graph_message(STATE, Rates(), "/scope")
    assert graph["nodes"] == ["/b", "/c", "/gen", "/proc", "/quiet"]
    assert graph["topics"] == [
        {"name": "/lone", "datatype": "*"},
        {"name": "/signal", "datatype": "a/B"},
        {"name": "/wanted", "datatype": "*"},
    ]
    assert [(edge["from"], edge["topic"], edge["to"]) for edge in graph["edges"]] == [
        ("/b", "/lone", None),
        ("/gen", "/lone", None),
        ("/gen", "/signal", "/c"),
        ("/gen", "/signal", "/proc"),
        (None, "/wanted", "/c"),
    ]


@settings(max_examples=30)
@given(st.lists(st.integers(0, 1000), min_size=1, max_size=10), st.floats(0.5, 5.0))
def test_a_rate_is_messages_by_time(steps: List[int], period: float) -> None:
    rates, count = Rates(), 0
    rates.add_counts("/gen", counts("/signal", (1, 0), (2, 0)), 0.0)
    assert rates.of("/gen", "/signal") is None
    for index, step in enumerate(steps, 1):
        count += step
        # The second connection loses messages.
        rates.add_counts("/gen", counts("/signal", (1, count), (2, count // 2)), index * period)
        assert rates.of("/gen", "/signal") == pytest.approx(step / period)
    edges = graph_message(STATE, rates, "/scope")["edges"]
    shown = [edge["rate"] for edge in edges if edge["topic"] == "/signal"]
    assert shown == [rates.of("/gen", "/signal")] * 2


def test_a_connection_that_is_gone_has_no_rate() -> None:
    rates = Rates()
    rates.add_counts("/gen", counts("/signal", (1, 0)), 0.0)
    rates.add_counts("/gen", counts("/signal", (1, 10)), 1.0)
    rates.add_counts("/gen", counts("/signal"), 2.0)
    assert rates.of("/gen", "/signal") is None


def test_restarted_node_starts_a_new_count() -> None:
    rates = Rates()
    rates.add_counts("/gen", counts("/signal", (1, 1000)), 0.0)
    rates.add_counts("/gen", counts("/signal", (1, 5)), 1.0)
    assert rates.of("/gen", "/signal") is None
    rates.add_counts("/gen", counts("/signal", (1, 15)), 2.0)
    assert rates.of("/gen", "/signal") == pytest.approx(10.0)
    rates.keep({"/other"})
    assert rates.of("/gen", "/signal") is None


def test_removed_connections_and_topics_are_dropped() -> None:
    rates = Rates()
    for number in range(100):
        rates.add_counts(
            "/gen", counts(f"/topic{number // 2}", (number // 2, number)), float(number)
        )
    assert rates.of("/gen", "/topic48") is None and rates.of("/gen", "/topic49") == 1.0
    assert len(rates._counts["/gen"]) == len(rates._rates["/gen"]) == 1


class Feed:
    """Feed of the graph, whose nodes are counted by a fake."""

    def __init__(self, monkeypatch: "pytest.MonkeyPatch") -> None:
        self.worker, self.send, self.now, self.count = SlowWorker(), mock.Mock(), 0.0, 0
        self.silent: Set[str] = set()
        queries = mock.Mock(**{"message_counts.side_effect": self.answers})
        monkeypatch.setattr(graph_feed, "NodeQueries", lambda _name: queries)
        self.feed = graph_feed.GraphFeed("/gen_scope", self.worker, self.send)

    def answers(self, nodes: Set[str]) -> Dict[str, Any]:
        self.asked = sorted(nodes)
        self.now, self.count = self.now + 1.0, self.count + 10
        known = {"/gen": [counts("/signal", (1, self.count)), counts("/lone", (2, self.count))]}
        return {
            node: (self.now, [[one[0][0] for one in known.get(node, [])]])
            for node in nodes - self.silent
        }

    def look(self, is_shown: bool = True, state: GraphState = STATE) -> Dict[str, Any]:
        """Poll the graph; return the rates by topic."""
        self.send.reset_mock()
        self.feed.on_state(state, is_shown)
        while self.worker.work:
            self.worker.work.pop(0)()
        graph: Any = self.feed.message()
        assert not is_shown or self.send.call_args == mock.call(graph)
        edges = [edge for edge in graph["edges"] if edge["from"] == "/gen"]
        return {edge["topic"]: edge["rate"] for edge in edges}


def test_rates_are_known_while_a_page_shows_the_graph(monkeypatch: "pytest.MonkeyPatch") -> None:
    feed = Feed(monkeypatch)
    assert feed.feed.message() is None
    unknown, known = {"/signal": None, "/lone": None}, {"/signal": 10.0, "/lone": 10.0}
    own = STATE._replace(publishers=[*STATE.publishers, ("/own", ["/gen_scope"])])
    assert feed.look(state=own) == unknown and feed.asked == ["/b", "/gen", "/proc"]
    assert feed.look() == known
    feed.silent = {"/gen"}
    assert feed.look() == unknown  # not the rate of before
    feed.silent = set()
    assert (feed.look(), feed.look()) == (unknown, known)
    assert feed.look(is_shown=False) == unknown and not feed.send.called
    assert feed.look() == unknown


def test_failed_count_does_not_keep_the_graph_from_pages(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    feed = Feed(monkeypatch)
    monkeypatch.setattr(feed.feed._queries, "message_counts", mock.Mock(side_effect=OSError))
    assert set(feed.look()) == {"/signal", "/lone"}


def test_node_that_has_restarted_has_no_rate_for_a_moment() -> None:
    rates = Rates()
    for now, count in ((0.0, 100), (1.0, 110), (2.0, 5)):
        rates.add_counts("/gen", counts("/signal", (1, count)), now)
    assert rates.of("/gen", "/signal") is None
