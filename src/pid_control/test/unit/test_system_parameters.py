"""Tests of the motor's parameters."""

import numpy

from first_order_sys_sim.first_order_plant import FirstOrderPlant
from pid_control.plant.system_parameters import SystemParameters


def test_plant_is_as_the_parameters_say() -> None:
    given = SystemParameters(
        system_param_K=2.0, system_param_T=0.3, system_max_speed=4.0, system_min_input=0.5
    )
    assert given.plant[:4] == (2.0, 0.3, 4.0, 0.5)


def test_each_parameter_has_its_default_range_and_unit() -> None:
    declared = SystemParameters.declared
    assert {name: (one.default, one.range, one.unit) for name, one in declared.items()} == {
        "system_node_rate": (1000.0, "[0.1, 10000]", "Hz"),
        "system_sample_time": (0.002, "[0.0001, 1000]", "s"),
        "system_param_K": (13.1, "[-1e6, 1e6]", "rad/s"),
        "system_param_T": (0.04, "(0, 1e6]", "s"),
        "system_initial_cond": (0.0, "[-1e9, 1e9]", "rad/s"),
        "system_max_speed": (13.0, "(0, 1e9]", "rad/s"),
        "system_min_input": (0.05, "[0, 1e9]", ""),
        "system_dead_time": (0.0, "[0, 1000]", "s"),
    }


def test_dead_zone_includes_its_float32_edge() -> None:
    plant = FirstOrderPlant(SystemParameters().plant)
    plant.hold(0.0, float(numpy.float32(0.05)))
    assert plant.output(1.0) == 0.0
    plant.hold(1.0, 0.051)
    assert plant.output(2.0) > 0.6
