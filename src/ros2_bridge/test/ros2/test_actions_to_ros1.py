"""Action servers of ROS 2, used from ROS 1."""

import random
import statistics
from typing import Iterator

import both
import pytest
from action_parts import Client1 as Client
from action_server2 import ABORT, PERSIST, REJECT, SUCCEED, Server
from rclpy.node import Node

from nodekit.testing.waiting import wait_until
from ros2_bridge.actions.ros2_goal_tracker import REJECTED


@pytest.fixture(scope="module")
def server(ros: both.Both, bridge: both.Bridge) -> Iterator[None]:
    node = Node("grabber")
    Server(node, "/hand/grab")
    ros.executor.add_node(node)
    yield
    ros.executor.remove_node(node)
    node.destroy_node()


@pytest.fixture(scope="module")
def client(server: None) -> Iterator[Client]:
    with Client("/hand/grab") as running:
        yield running


def test_goal_runs_with_feedback_to_its_result(client: Client) -> None:
    client.tell(f"send one 2.0 {SUCCEED}")
    assert client.end_of("one") == "SUCCEEDED one"
    heard = client.feedback("one")
    assert len(heard) > 3 and heard == sorted(heard, reverse=True) and max(heard) <= 2.0


def test_goals_end_as_the_server_ends_them(client: Client) -> None:
    client.tell(f"send bad 0.1 {ABORT}")
    client.tell(f"send no 0.1 {REJECT}")
    assert client.end_of("bad") == "ABORTED bad"
    assert client.end_of("no") == f"REJECTED - {REJECTED}"


def test_single_goal_is_cancelled(client: Client) -> None:
    for key in ("stays", "goes"):
        client.tell(f"send {key} 60.0")
    wait_until(lambda: client.feedback("goes") and client.feedback("stays"), lambda: "no feedback")
    client.tell("cancel goes")
    assert client.end_of("goes") == "PREEMPTED goes"
    before = len(client.feedback("stays"))
    wait_until(lambda: len(client.feedback("stays")) > before + 2, lambda: "it does not go on")
    client.tell("cancel stays")
    assert client.end_of("stays") == "PREEMPTED stays"


def test_those_until_a_time_and_all_are_cancelled(client: Client) -> None:
    for key in ("first", "second", "third"):
        client.tell(f"send {key} 60.0")
    wait_until(lambda: client.feedback("third"), lambda: "no feedback")
    client.tell("cancel_until second")
    assert client.end_of("first") == "PREEMPTED first"
    assert client.end_of("second") == "PREEMPTED second"
    assert not client.ended("third")
    client.tell("cancel_all")
    assert client.end_of("third") == "PREEMPTED third"


def test_refused_cancellation_continues_goal(bridge: both.Bridge, client: Client) -> None:
    client.tell(f"send stubborn 6.0 {PERSIST}")
    wait_until(lambda: client.feedback("stubborn"), lambda: "no feedback")
    client.tell("cancel stubborn")
    bridge.wait_for_log("/hand/grab: the server in ROS 2 does not cancel")
    assert client.end_of("stubborn") == "SUCCEEDED stubborn"


def test_goals_are_listed_five_times_a_second(ros: both.Both, client: Client) -> None:
    recorder = ros.hear1("/hand/grab/status", "actionlib_msgs/GoalStatusArray")
    recorder.wait(12)
    heard = list(recorder.heard)
    stamps = [int.from_bytes(m._buff[8:12], "little") for m in heard]
    seconds = [int.from_bytes(m._buff[4:8], "little") for m in heard]
    times = [whole + 1e-9 * part for whole, part in zip(seconds, stamps)]
    # The median: after one that a busy machine has held up, the next one is due in less.
    assert 0.1 < statistics.median(late - early for early, late in zip(times, times[1:])) < 0.7
    recorder.end()


def test_many_goals_are_neither_lost_nor_duplicated(client: Client) -> None:
    chance, keys = random.Random(2), [f"many{number}" for number in range(200)]
    for key in keys:
        client.tell(f"send {key} {chance.uniform(0.0, 1.0)} {chance.choice((SUCCEED, ABORT))}")
        if chance.random() < 0.5:
            client.tell(f"cancel {key}")
    ends = [client.end_of(key) for key in keys]
    for key, end in zip(keys, ends):
        state, _, rest = end.partition(" ")
        is_right = rest == key or (state == "RECALLED" and rest.startswith(("-", key)))
        assert is_right, (key, end)
    assert {"SUCCEEDED", "ABORTED"} < {end.partition(" ")[0] for end in ends}
    assert not client.logged("already in the DONE state")


def test_server_continues_goal_of_killed_client(ros: both.Both, client: Client) -> None:
    with Client("/hand/grab") as other:
        other.tell("send orphan 60.0")
        wait_until(lambda: other.feedback("orphan"), lambda: "no feedback")
    client.tell("cancel_all")

    def listed() -> bool:
        recorder = ros.hear1("/hand/grab/status", "actionlib_msgs/GoalStatusArray")
        recorder.wait(1)
        recorder.end()
        return b"action_client1" in recorder.heard[-1]._buff

    wait_until(lambda: not listed(), lambda: "the goal goes on")
