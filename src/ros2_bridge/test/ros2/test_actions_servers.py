"""Action servers that end before their goals, or whose names do not fit."""

import os
import signal

import both
import pytest
from action_msgs.msg import GoalStatus
from action_parts import Client1, Client2, Server1, Server2

from nodekit.testing.waiting import wait_until
from ros2_bridge.actions.ros2_goal_tracker import GONE


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGKILL, marks=pytest.mark.extended)]
)
def test_goals_of_a_server_that_goes_are_aborted(bridge: both.Bridge, number: int) -> None:
    # A unique name: the bridge may still list the server of the previous test.
    action = f"/foot/kick{number}"
    with Server2(action) as server, Client1(action) as client:
        client.tell("send on 60.0")
        wait_until(lambda: client.feedback("on"), lambda: "no feedback")
        os.kill(server.popen.pid, number)
        server.wait()
        assert client.end_of("on") == f"ABORTED - {GONE}"


def test_servers_of_nodes_with_same_name_are_logged(bridge: both.Bridge) -> None:
    with Server2("/arm/left"), Server2("/arm/right"):
        bridge.wait_for_log("several nodes of ROS 2 are called /action_server2")


@pytest.mark.extended
def test_servers_in_both_roses_are_logged(bridge: both.Bridge) -> None:
    with Server1("/arm/twice"), Server2("/arm/twice"):
        bridge.wait_for_log("not bridged: /arm/twice: both ROSes list a server", "rosnode cleanup")


def test_action_with_too_long_a_name_keeps_no_other(ros: both.Both, bridge: both.Bridge) -> None:
    long = f"/{'a' * 229}"  # ROS 2 takes its topics, but not its services
    with Server1(long, "talkative"), Server1("/leg/jump") as server:
        bridge.wait_for_log(f"not bridged: {long}: ")
        client = Client2(ros, "/leg/jump")
        client.send("up", 0.1)
        assert client.accepted("up") and client.end("up") == GoalStatus.STATUS_SUCCEEDED
        client.close()
        assert server.popen.poll() is None and not bridge.logged("Traceback")
