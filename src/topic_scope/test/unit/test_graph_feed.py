"""Graph message of pages, and rates from counts."""

from typing import List

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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
