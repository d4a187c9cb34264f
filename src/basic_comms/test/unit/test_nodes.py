"""Nodes' handling of input, without a master."""

import math
import threading
from types import SimpleNamespace
from typing import Any, Iterator, List

import pytest
import rospy
from helpers.offline_node import OfflineNode
from std_srvs.srv import SetBoolRequest, TriggerRequest

from basic_comms.conditioning.conditioner import Conditioner
from basic_comms.msg import signal_msg
from basic_comms.nodes import process
from basic_comms.nodes.process import Process
from basic_comms.nodes.signal_generator import SignalGenerator

PLAIN = {"amplitude_scale": 1.0, "phase_shift": 0.0, "keep_positive": False}


class Clocks:
    """Fake machine clock and ROS time, and the logged warnings."""

    def __init__(self) -> None:
        self.machine = self.ros = 100.0
        self.simulated = False
        self.warnings: List[str] = []


@pytest.fixture
def clocks(monkeypatch: Any) -> Iterator[Clocks]:
    """Return clocks that the process node looks at."""
    made = Clocks()
    monkeypatch.setattr(process, "time", SimpleNamespace(monotonic=lambda: made.machine))
    monkeypatch.setattr(rospy, "get_time", lambda: made.ros)
    monkeypatch.setattr(rospy.rostime, "is_wallclock", lambda: not made.simulated)
    monkeypatch.setattr(rospy, "logwarn", lambda text, *args: made.warnings.append(text % args))
    yield made


def sample(time_x: float, value: float = 0.5) -> signal_msg:
    return signal_msg(2.0, 0.0, time_x, value)


def answers(node: OfflineNode) -> List[float]:
    return [message.data for message in node.published["proc_signal"]]


def test_process_answers_each_sample_immediately() -> None:
    node = OfflineNode(**PLAIN)
    Process(node)
    node.receive([sample(0.0, 0.5), sample(0.1, 0.75)], True)
    node.receive([sample(0.2, 1.0)], True)
    assert answers(node) == [0.5, 0.75, 1.0]


def test_at_a_rate_a_sample_is_answered_at_its_ticks_only() -> None:
    node = OfflineNode(rate=50.0, **PLAIN)
    Process(node)
    node.tick(0.0)
    node.receive([sample(0.0, 0.5)], True)
    node.receive([sample(0.1, 0.75), sample(0.2, 1.0)], True)
    assert answers(node) == []
    node.tick(0.02)
    node.tick(0.04)
    assert answers(node) == [1.0, 1.0]


def test_samples_that_are_all_left_out_do_no_harm(clocks: Clocks) -> None:
    node = OfflineNode(**PLAIN)
    Process(node)
    node.receive([sample(0.0, math.nan), sample(0.1, math.inf)], True)
    node.tick(0.0)
    assert answers(node) == []
    node.receive([sample(0.2, 0.5), sample(0.3, math.nan)], True)
    assert answers(node) == [0.5]
    (warning,) = clocks.warnings  # the second warning is throttled
    assert warning.startswith("/signal: 2 samples dropped so far")


def test_two_process_nodes_in_one_process_both_warn_of_dropped_samples(clocks: Clocks) -> None:
    nodes = [OfflineNode(**PLAIN) for _ in range(2)]
    for node in nodes:
        Process(node)
    for node in nodes * 2:
        node.receive([sample(0.0, math.nan)], True)
    assert len(clocks.warnings) == 2
    assert all("1 samples dropped so far" in warning for warning in clocks.warnings)


@pytest.mark.parametrize("simulated", [True, False])
def test_lateness_goes_by_the_clock_that_the_signal_goes_by(
    clocks: Clocks, simulated: bool
) -> None:
    clocks.simulated = simulated
    node = OfflineNode(**PLAIN)
    Process(node)
    node.receive([sample(0.0)], True)
    name = "ros" if simulated else "machine"
    setattr(clocks, "machine" if simulated else "ros", 5000.0)
    node.receive([sample(0.1)], True)
    assert clocks.warnings == []
    setattr(clocks, name, 120.0)
    node.receive([sample(0.2)], True)
    assert clocks.warnings == ["/signal: samples are 19.9 s late"]
    node.receive([sample(20.0)], True)
    assert clocks.warnings[1:] == [
        "/signal: samples are in time again; 1 were late, by up to 19.9 s"
    ]


def test_samples_that_jump_with_the_clock_are_not_called_late(clocks: Clocks) -> None:
    clocks.simulated = True
    node = OfflineNode(**PLAIN)
    Process(node)
    node.receive([sample(0.0)], True)
    node.receive([sample(1000.1)], True)  # before the node has received /clock
    clocks.ros += 1000.2
    node.receive([sample(1000.2)], True)
    assert clocks.warnings == []


def test_concurrent_publishers_alternate(monkeypatch: Any) -> None:
    node = OfflineNode(**PLAIN)
    Process(node)
    inside: List[int] = []
    together = threading.Event()

    def condition(*_: Any) -> float:
        inside.append(1)
        if len(inside) > 1:
            together.set()
        together.wait(0.1)  # the other comes in now, if it can
        inside.pop()
        return 1.0

    monkeypatch.setattr(Conditioner, "process", condition)
    connections = [
        threading.Thread(target=node.receive, args=([sample(float(n))], True)) for n in range(2)
    ]
    for connection in connections:
        connection.start()
    for connection in connections:
        connection.join(10.0)
    assert answers(node) == [1.0, 1.0]
    assert not together.is_set()


def statuses(node: OfflineNode) -> List[str]:
    return [message.data for message in node.published["~status"]]


def test_status_is_published_on_change_and_after_reset() -> None:
    node = OfflineNode()
    SignalGenerator(node)
    for elapsed in (0.0, 0.1, 0.2):
        node.tick(elapsed)
    assert statuses(node) == ["running 0.000"]
    node.services["~reset"](TriggerRequest())
    node.tick(0.3)
    node.tick(0.4)
    assert statuses(node)[1:] == ["running 0.000"]
    node.services["~enable"](SetBoolRequest(False))
    node.tick(0.5)
    node.services["~reset"](TriggerRequest())
    node.tick(0.6)
    assert statuses(node)[2:] == ["idle 0.200", "idle 0.000"]
    assert [message.time_x for message in node.published["signal"]] == pytest.approx(
        [0.0, 0.1, 0.2, 0.0, 0.1, 0.2, 0.0]
    )
