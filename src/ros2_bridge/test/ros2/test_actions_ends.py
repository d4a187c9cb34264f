"""Goals whose server or whose bridge ends before them."""

import os
import signal

import both
import pytest
from action_parts import Client1, Client2, Server1, Server2, cancel

from nodekit.testing.waiting import wait_until
from ros2_bridge.actions.goals_of_ros2 import GONE


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_goals_of_a_server_that_goes_are_aborted(ros: both.Both, number: int) -> None:
    with both.Bridge(), Server2("/foot/kick") as server, Client1("/foot/kick") as client:
        client.tell("send on 60.0")
        wait_until(lambda: client.feedback("on"), lambda: "no feedback")
        os.kill(server.popen.pid, number)
        server.wait()
        assert client.end_of("on") == f"ABORTED - {GONE}"


def test_goal_is_lost_where_the_bridge_was_killed(ros: both.Both) -> None:
    with Server2("/leg/walk"):
        with both.Bridge() as bridge, Client1("/leg/walk") as client:
            client.tell("send on 60.0")
            wait_until(lambda: client.feedback("on"), lambda: "no feedback")
            bridge.popen.send_signal(signal.SIGKILL)
            bridge.wait()
            with both.Bridge():
                assert client.end_of("on") == "LOST -"  # by the rules of ROS 1


def test_bridge_that_is_killed_leaves_the_goal_to_the_server(ros: both.Both) -> None:
    with Server1("/leg/step") as server:
        with both.Bridge() as bridge:
            client = Client2(ros, "/leg/step")
            client.send("on", 60.0)
            assert client.accepted("on")
            bridge.popen.send_signal(signal.SIGKILL)
            bridge.wait()
        with both.Bridge():
            # By the rules of ROS 2 the client still waits; the goal is known by the same id. For a
            # while ROS 2 takes the killed bridge for a server too, which may be asked in vain.
            wait_until(
                lambda: cancel(ros, "/leg/step", client.handles["on"], patience=2.0),
                lambda: "the goal is not known",
            )
            assert "on" not in client.results
        client.close()
        assert server.popen.poll() is None
