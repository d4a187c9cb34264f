"""Statuses for /diagnostics and the table of the bridge's health."""

import sys
from typing import Dict, Sequence

import pytest

from ros2_bridge.commands import report
from ros2_bridge.health.reports import ERROR, OK, WARN, BridgeHealth, is_well, statuses, table
from ros2_bridge.health.topic_health import TopicCounts, TopicHealth
from ros2_bridge.rules.selection import Route


def health(
    topics: Dict[Route, TopicHealth], not_bridged: Sequence[str] = (), trouble: str = ""
) -> BridgeHealth:
    return BridgeHealth(topics, 7, 1, not_bridged, trouble, 90_000_000)


IMAGE = TopicHealth(TopicCounts(300, lost=4, held=6_000), 29.96, {"lost": 3})
SCAN = TopicHealth(TopicCounts(50, refused=1, thinned=2, held=64_000), 10.0, {})
IDLE = TopicHealth(TopicCounts(), 0.0, {})
TOPICS = {
    Route("/image", False): IMAGE,
    Route("/scan", True): SCAN,
    Route("/idle", True): IDLE,
    Route("/idle2", True): IDLE,
}
FINE = {route: state for route, state in TOPICS.items() if not state.recent}


def test_statuses_are_the_same_whatever_is_bridged() -> None:
    names = ["bridge", "topics to ROS 2", "topics to ROS 1", "not bridged"]
    for one in (health({}), health(TOPICS, ["/x: why"]), health({}, trouble="no master")):
        assert [status.name for status in statuses(one)] == names


def test_bridge_without_faults_is_well() -> None:
    one = health(FINE)
    assert [status.level for status in statuses(one)] == [OK] * 4
    assert is_well(one)
    bridge, to_ros2, to_ros1, skipped = statuses(one)
    assert bridge.message == "follows both graphs"
    assert bridge.values == [
        ("topics to ROS 2", "3"),
        ("topics to ROS 1", "0"),
        ("services", "7"),
        ("actions", "1"),
        ("memory [bytes]", "90000000"),
    ]
    assert to_ros2.message == "10.0 messages/s; topics with messages: 1"
    assert to_ros2.values == [
        (
            "/scan",
            "10.0 Hz, 50 passed, 1 refused, 2 dropped by max_rate, queue at most 64000 bytes",
        ),
        ("topics without messages", "2"),
    ]
    assert to_ros1.values == [("topics without messages", "0")]
    two = statuses(health({**FINE, Route("/scan2", True): SCAN}))[1]
    assert two.message == "20.0 messages/s; topics with messages: 2"
    assert (skipped.message, skipped.values) == ("nothing", [])


def test_recent_fault_is_a_warning_of_its_direction() -> None:
    one = health(TOPICS)
    assert [status.level for status in statuses(one)] == [OK, OK, WARN, OK]
    assert not is_well(one)
    status = statuses(one)[2]
    assert status.message == "in the last 10 s: /image (3 lost on the way from ROS 2)"
    assert status.values[0] == (
        "/image",
        "30.0 Hz, 300 passed, 4 lost on the way from ROS 2, queue 6000 bytes",
    )


def test_warning_names_three_topics_and_counts_the_others() -> None:
    state = TopicHealth(TopicCounts(refused=1, unread=2), 0.0, {"refused": 1, "unread": 2})
    faulty = {Route(f"/t{number}", False): state for number in range(5)}
    one = health({**faulty, Route("/fine", False): SCAN})
    what = "(1 refused, 2 dropped for subscribers that do not read)"
    expected = f"in the last 10 s: /t0 {what}, /t1 {what}, /t2 {what}"
    assert statuses(one)[2].message == f"{expected} and 2 more"
    three = {route: state for route, state in faulty.items() if route.name < "/t3"}
    assert statuses(health(three))[2].message == expected


def test_names_that_are_not_bridged_are_a_warning_with_each_reason() -> None:
    status = statuses(health({}, ["/a: no type"]))[3]
    assert (status.level, status.message) == (WARN, "/a: no type; ~deny excludes a name")
    status = statuses(health({}, ["/a: no type", "/b: differs"]))[3]
    assert status.message == "2, such as /a: no type; ~deny excludes a name"
    assert status.values == [("1", "/a: no type"), ("2", "/b: differs")]


def test_bridge_that_cannot_follow_the_graphs_is_an_error() -> None:
    one = health(FINE, trouble="nothing new is bridged: no master")
    status = statuses(one)[0]
    assert (status.level, status.message) == (ERROR, "nothing new is bridged: no master")
    assert len(status.values) == 5
    assert not is_well(one)


def test_table_has_a_row_for_each_topic_with_messages() -> None:
    lines = table("/ros2_bridge", health(TOPICS, ["/x: why"])).splitlines()
    assert lines == [
        "/ros2_bridge: follows both graphs; topics to ROS 2 3, topics to ROS 1 1, services 7,"
        " actions 1, memory [bytes] 90000000",
        "topic   to       Hz  passed  lost  refused  unread  thinned                queue",
        "/image  ROS 1  30.0     300     4        0       0        0           6000 bytes",
        "/scan   ROS 2  10.0      50     0        1       0        2  at most 64000 bytes",
        "topics without messages: 2",
        "WARN topics to ROS 1: in the last 10 s: /image (3 lost on the way from ROS 2)",
        "not bridged: /x: why",
    ]


def test_table_without_messages_has_no_columns() -> None:
    lines = table("/b", health({Route("/idle", True): IDLE}, trouble="no master")).splitlines()
    assert lines[0].startswith("/b: ERROR no master; topics to ROS 2 1,")
    assert lines[1:] == ["topics without messages: 1"]


@pytest.mark.parametrize("given", ["--topics", "/scan"])
def test_report_refuses_arguments_that_it_does_not_know(
    given: str, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    monkeypatch.setattr(sys, "argv", ["report", "__ns:=lab", given])
    with pytest.raises(SystemExit) as ended:
        report.main()
    assert ended.value.code == 2
    assert f"unrecognized arguments: {given}" in capsys.readouterr().err
