"""Action servers of ROS 1, used from ROS 2."""

import contextlib
import random
from typing import Any, Dict, Iterator, List

import both
import pytest
import rospy
from action_msgs.msg import GoalStatus as Status
from action_msgs.srv import CancelGoal
from action_parts import (
    ABORT,
    PEND,
    PERSIST,
    REJECT,
    SUCCEED,
    Client1,
    Client2,
    Server1,
    cancel,
)
from rclpy.action.graph import (
    get_action_names_and_types,
    get_action_server_names_and_types_by_node,
)
from test_topics import RCLError

from nodekit.testing.processes import hanging
from nodekit.testing.waiting import wait_until


@pytest.fixture(scope="module")
def server(ros: both.Both, bridge: both.Bridge) -> Iterator[Server1]:
    with Server1("/arm/reach") as running:
        yield running


@pytest.fixture(scope="module")
def client(ros: both.Both, server: Server1) -> Iterator[Client2]:
    made = Client2(ros, "/arm/reach")
    yield made
    made.close()


def test_it_is_listed_as_that_of_its_node(ros: both.Both, client: Client2) -> None:
    kind = ["bot_controller_demo_msgs/action/GoTo"]
    assert dict(get_action_names_and_types(ros.node))["/arm/reach"] == kind

    def of_node() -> List[Any]:
        with contextlib.suppress(RCLError):  # the node has not been discovered yet
            return list(get_action_server_names_and_types_by_node(ros.node, "action_server1", "/"))
        return []

    wait_until(lambda: of_node() == [("/arm/reach", kind)], lambda: str(of_node()))
    plain = [name for name, _ in ros.node.get_topic_names_and_types()]
    assert not [name for name in plain if name.startswith("/arm/reach/") and "_action" not in name]


def test_goal_runs_with_feedback_to_its_result(client: Client2) -> None:
    client.send("one", 2.0)
    assert client.accepted("one")
    assert client.end("one") == Status.STATUS_SUCCEEDED
    assert client.results["one"].result.progress.phase == "one"
    heard = client.feedback["one"]
    assert len(heard) > 3 and heard == sorted(heard, reverse=True) and max(heard) <= 2.0


def test_goals_end_as_the_server_ends_them(client: Client2) -> None:
    for key, what in (("good", SUCCEED), ("bad", ABORT), ("no", REJECT)):
        client.send(key, 0.2, what)
    assert [client.accepted(key) for key in ("good", "bad", "no")] == [True, True, False]
    assert client.end("good") == Status.STATUS_SUCCEEDED
    assert client.end("bad") == Status.STATUS_ABORTED


def test_single_goal_is_cancelled(ros: both.Both, client: Client2) -> None:
    for key, seconds in (("stays", 1.0), ("goes", 60.0)):
        client.send(key, seconds)
        assert client.accepted(key)
    answer = cancel(ros, "/arm/reach", client.handles["goes"])
    assert answer.return_code == CancelGoal.Response.ERROR_NONE
    (goal,) = answer.goals_canceling
    handle = client.handles["goes"]
    assert (goal.goal_id, goal.stamp) == (handle.goal_id, handle.stamp)
    assert client.end("goes") == Status.STATUS_CANCELED
    assert client.end("stays") == Status.STATUS_SUCCEEDED
    answer = cancel(ros, "/arm/reach", client.handles["goes"])
    assert answer.return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED
    client.handles["goes"].goal_id.uuid[0] ^= 1
    answer = cancel(ros, "/arm/reach", client.handles["goes"])
    assert answer.return_code == CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID


def test_those_until_a_time_and_all_are_cancelled(ros: both.Both, client: Client2) -> None:
    for key in ("first", "second", "third"):
        client.send(key, 60.0)
        assert client.accepted(key)
    answer = cancel(ros, "/arm/reach", until=client.handles["second"].stamp)
    assert len(answer.goals_canceling) == 2
    assert client.end("first") == client.end("second") == Status.STATUS_CANCELED
    assert "third" not in client.results
    assert len(cancel(ros, "/arm/reach").goals_canceling) == 1
    assert client.end("third") == Status.STATUS_CANCELED


def test_cancellation_until_future_time_spares_later_goals(ros: both.Both, client: Client2) -> None:
    client.send("early", 60.0)
    assert client.accepted("early")
    ahead = client.handles["early"].stamp
    ahead.sec += 3600
    assert len(cancel(ros, "/arm/reach", until=ahead).goals_canceling) == 1
    assert client.end("early") == Status.STATUS_CANCELED
    client.send("afterwards", 0.1)
    assert client.accepted("afterwards") and client.end("afterwards") == Status.STATUS_SUCCEEDED


def test_ignored_cancellation_is_reported(ros: both.Both, client: Client2) -> None:
    client.send("stubborn", 6.0, PERSIST)
    assert client.accepted("stubborn")
    assert len(cancel(ros, "/arm/reach", client.handles["stubborn"]).goals_canceling) == 1
    wait_until(
        lambda: client.state("stubborn") == Status.STATUS_CANCELING,
        lambda: str(client.state("stubborn")),
    )
    assert client.end("stubborn") == Status.STATUS_SUCCEEDED


def test_undecided_goal_is_accepted_after_timeout(
    ros: both.Both, bridge: both.Bridge, client: Client2
) -> None:
    # The server lists a goal that is pending only with its next state, up to 0.2 s later.
    rospy.set_param("/ros2_bridge/service_timeout", 4.0)
    bridge.wait_for_log("service_timeout: 5 -> 4")
    client.send("later", 0.0, PEND)
    assert client.accepted("later")
    wait_until(
        lambda: client.state("later") == Status.STATUS_ACCEPTED,
        lambda: str(client.state("later")),
    )
    cancel(ros, "/arm/reach", client.handles["later"])
    assert client.end("later") == Status.STATUS_CANCELED


def test_silent_server_has_rejected(bridge: both.Bridge, server: Server1, client: Client2) -> None:
    with hanging(server.popen.pid):
        client.send("unheard", 1.0)
        assert not client.accepted("unheard")
    bridge.wait_for_log("/arm/reach: no status of a goal from ROS 2 received")
    rospy.set_param("/ros2_bridge/service_timeout", 60.0)  # for many goals on a busy machine
    bridge.wait_for_log("service_timeout: 4 -> 60")
    client.send("heard", 0.1)
    assert client.accepted("heard") and client.end("heard") == Status.STATUS_SUCCEEDED


def test_many_goals_are_neither_lost_nor_duplicated(ros: both.Both, client: Client2) -> None:
    chance, keys = random.Random(1), [f"many{number}" for number in range(200)]
    statuses: Dict[str, int] = {}
    lasting = set(keys[::20])  # until they are cancelled, however slow the machine is
    for key in keys:
        seconds = 600.0 if key in lasting else chance.uniform(0.0, 1.0)
        client.send(key, seconds, chance.choice((SUCCEED, SUCCEED, ABORT)))
    for key in keys:
        assert client.accepted(key)
        if key in lasting or chance.random() < 0.5:
            client.handles[key].cancel_goal_async()
    for key in keys:
        statuses[key] = client.end(key)
        assert client.results[key].result.progress.phase == key, statuses[key]
    assert len(set(statuses.values())) == 3


def test_killed_client_does_not_affect_others(
    bridge: both.Bridge, server: Server1, client: Client2
) -> None:
    with Client1("/arm/reach", ros="2") as other:

        def is_fed() -> bool:
            if not other.feedback("orphan") and other.ended("orphan"):
                other.lines.clear()  # a busy server has had no time for it: once more
                other.tell("send orphan 1.0")
            return bool(other.feedback("orphan")) and not other.ended("orphan")

        other.tell("send orphan 1.0")
        wait_until(is_fed, lambda: "no feedback")
    client.send("beside", 2.0)  # which the orphan ends before
    assert client.accepted("beside") and client.end("beside") == Status.STATUS_SUCCEEDED
    assert not bridge.logged("Traceback")


def test_result_is_kept(ros: both.Both, client: Client2) -> None:
    client.send("kept", 0.0)
    assert client.accepted("kept") and client.end("kept") == Status.STATUS_SUCCEEDED
    again = client.handles["kept"].get_result_async()
    wait_until(again.done, lambda: "no second answer")
    assert again.result().result.progress.phase == "kept"


def test_goals_of_a_killed_server_are_aborted(
    ros: both.Both, bridge: both.Bridge, server: Server1, client: Client2
) -> None:
    client.send("abandoned", 60.0)
    assert client.accepted("abandoned")
    server.end()
    assert client.end("abandoned") == Status.STATUS_ABORTED
    client.send("too late", 0.1)
    assert not client.accepted("too late")
    with Server1("/arm/reach"):  # whom the master takes for the same
        wait_until(lambda: client.send("again", 0.0) and client.accepted("again"), lambda: "no")
