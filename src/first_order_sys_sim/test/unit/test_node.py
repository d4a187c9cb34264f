"""When the node's inputs act, also on a machine that is late; without a master."""

import math
from types import SimpleNamespace
from typing import Any, Callable, List

import pytest
import rospy
from std_msgs.msg import Float32

from first_order_sys_sim.nodes.first_order_sys import FirstOrderSystem

RATE, TAU, GAIN = 100.0, 0.05, 2.0


class Machine:
    """Fake node and clock, controlled by the test."""

    def __init__(self, monkeypatch: Any) -> None:
        self.clock = 1000.0
        self.tick: Callable[[float], None]
        self.hear: Callable[[Float32], None]
        self.outputs: List[float] = []
        monkeypatch.setattr(rospy, "get_time", lambda: self.clock)

    def declare_parameters(self, declaration: Any, on_change: Any) -> Any:
        values = {"system_node_rate": RATE, "system_param_T": TAU, "system_param_K": GAIN}
        return SimpleNamespace(values=declaration(system_sample_time=1e-4, **values))

    def create_publisher(self, *_: Any) -> Any:
        return SimpleNamespace(publish=lambda message: self.outputs.append(message.data))

    def create_subscription(self, _name: str, _kind: type, callback: Any, finite: bool) -> None:
        assert finite
        self.hear = callback

    def create_timer(self, _rate: Any, callback: Any, catch_up: float) -> None:
        self.tick = callback


@pytest.fixture
def machine(monkeypatch: Any) -> Machine:
    made = Machine(monkeypatch)
    FirstOrderSystem(made)  # type: ignore[arg-type]
    return made


def response(seconds: float) -> float:
    return GAIN * (1.0 - math.exp(-seconds / TAU))


@pytest.mark.parametrize("late", [0.0, 0.4])
@pytest.mark.parametrize("after, acts_after", [(0.004, 0.004), (0.3, 0.01), (-50.0, 0.0)])
def test_input_acts_between_the_last_output_and_the_next_however_late_that_was(
    machine: Machine, late: float, after: float, acts_after: float
) -> None:
    machine.tick(0.0)
    machine.clock += late + 1.0 / RATE
    machine.tick(1.0 / RATE)
    machine.clock += after  # below 0: it was set back
    machine.hear(Float32(1.0))
    machine.tick(2.0 / RATE)
    machine.tick(3.0 / RATE)
    expected = [response(elapsed - 0.01 - acts_after) for elapsed in (0.02, 0.03)]
    assert machine.outputs == pytest.approx([0.0, 0.0] + expected, abs=2e-4 * GAIN / TAU)
