"""Tests of the motor's parameters."""

import numpy

from first_order_sys_sim.first_order_plant import FirstOrderPlant
from pid_control.plant.system_parameters import SystemParameters


def test_plant_is_as_the_parameters_say() -> None:
    given = SystemParameters(
        system_param_K=2.0, system_param_T=0.3, system_max_speed=4.0, system_min_input=0.5
    )
    assert given.plant[:4] == (2.0, 0.3, 4.0, 0.5)


def test_dead_zone_includes_its_float32_edge() -> None:
    plant = FirstOrderPlant(SystemParameters().plant)
    plant.hold(0.0, float(numpy.float32(0.05)))
    assert plant.output(1.0) == 0.0
    plant.hold(1.0, 0.051)
    assert plant.output(2.0) > 0.6
