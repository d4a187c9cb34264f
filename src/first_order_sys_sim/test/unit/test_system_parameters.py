"""Description of the plant by the node's parameters."""

import struct

import pytest

from first_order_sys_sim.first_order_plant import FirstOrderPlant, PlantSettings
from first_order_sys_sim.system_parameters import SystemParameters
from nodekit import LARGEST_FLOAT32, to_float32


def test_plant_is_as_the_parameters_say() -> None:
    parameters = SystemParameters(
        system_param_K=2.0,
        system_param_T=0.3,
        system_max_output=5.0,
        system_min_input=0.5,
        method="euler",
    )
    assert parameters.plant == PlantSettings(2.0, 0.3, 5.0, 0.5, "euler")


@pytest.mark.parametrize("bound", [0.05, 0.1, 0.2, 0.3, 0.7])
def test_dead_zone_takes_its_bound_as_a_message_brings_it(bound: float) -> None:
    plant = FirstOrderPlant(SystemParameters(system_min_input=bound).plant)
    (carried,) = struct.unpack("<f", struct.pack("<f", bound))
    plant.hold(0.0, carried)
    assert plant.output(1.0) == 0.0
    plant.hold(1.0, carried * 1.000001)
    assert plant.output(2.0) != 0.0


def test_float32_has_a_largest_value() -> None:
    assert to_float32(LARGEST_FLOAT32) == LARGEST_FLOAT32
    assert 0.2 < to_float32(0.2) == pytest.approx(0.2, rel=6e-8)
