"""Tests of the motor's parameters."""

import numpy
import pytest

from first_order_sys_sim.first_order_plant import FirstOrderPlant
from nodekit import ParameterError
from pid_control.plant.system_parameters import SystemParameters


def test_plant_is_as_the_parameters_say() -> None:
    given = SystemParameters(
        system_param_K=2.0, system_param_T=0.3, system_max_speed=4.0, system_min_input=0.5
    )
    assert given.plant[:4] == (2.0, 0.3, 4.0, 0.5)


@pytest.mark.parametrize(
    "name, least, largest",
    [
        ("system_node_rate", 0.1, 1e4),
        ("system_sample_time", 1e-4, 1e3),
        ("system_param_K", -1e6, 1e6),
        ("system_param_T", 1e-9, 1e6),
        ("system_initial_cond", -1e9, 1e9),
        ("system_max_speed", 1e-9, 1e9),
        ("system_min_input", 0.0, 1e9),
        ("system_dead_time", 0.0, 1e3),
    ],
)
def test_values_up_to_the_bounds_are_accepted(name: str, least: float, largest: float) -> None:
    for value, beyond in ((least, least - 0.01), (largest, largest + 0.01)):
        assert getattr(SystemParameters(**{name: value}), name) == value
        with pytest.raises(ParameterError, match=name):
            SystemParameters(**{name: beyond})


def test_dead_zone_includes_its_float32_edge() -> None:
    plant = FirstOrderPlant(SystemParameters().plant)
    plant.hold(0.0, float(numpy.float32(0.05)))
    assert plant.output(1.0) == 0.0
    plant.hold(1.0, 0.051)
    assert plant.output(2.0) > 0.6
