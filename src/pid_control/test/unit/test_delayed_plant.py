"""Tests of a plant with dead time."""

import math

import pytest

from first_order_sys_sim.first_order_plant import PlantSettings
from first_order_sys_sim.sampled_plant import SampledPlant
from pid_control.plant.delayed_plant import DelayedPlant

SETTINGS = PlantSettings(2.0, 1.0)


def delayed(dead_time: float, sample_time: float = 1e-3) -> DelayedPlant:
    return DelayedPlant(SampledPlant(SETTINGS, sample_time), dead_time)


def test_input_arrives_after_the_dead_time() -> None:
    plant = delayed(0.5)
    plant.set_input(1.0, 1.0)
    assert plant.output(1.5) == 0.0
    assert plant.output(2.5) == pytest.approx(-2.0 * math.expm1(-1.0))


def test_without_a_dead_time_it_is_the_plant_itself() -> None:
    plant, same = delayed(0.0), SampledPlant(SETTINGS, 1e-3)
    for number in range(20):
        for each in (plant, same):
            each.set_input(0.0371 * number, math.sin(number))
        assert plant.output(0.0371 * number + 0.01) == same.output(0.0371 * number + 0.01)


def test_no_input_overtakes_another_when_the_dead_time_becomes_shorter() -> None:
    plant = delayed(1.0)
    plant.set_input(0.0, 1.0)
    plant.change(0.1, SETTINGS, 1e-3, 0.0)
    plant.set_input(0.2, 0.0)
    assert plant.output(0.9) == 0.0
    # Both arrive at 1 s, and the later one counts.
    assert plant.output(3.0) == 0.0


def test_set_output_and_change_leave_earlier_inputs_their_time() -> None:
    for is_set in (False, True):
        plant = delayed(0.5)
        plant.set_input(0.0, 1.0)
        if is_set:
            plant.set_output(1.0, 0.0)
        else:
            plant.change(1.0, SETTINGS, 1e-3, 0.0)
        assert plant.output(1.5) == pytest.approx(-2.0 * math.expm1(-0.5 if is_set else -1.0))


def test_set_output_leaves_earlier_inputs_their_sample() -> None:
    plant = delayed(0.5, 0.4)
    plant.set_input(0.0, 1.0)  # it arrives at 0.5 s, and is sampled at 0.8 s
    plant.set_output(1.0, 0.0)
    assert plant.output(1.2) == pytest.approx(-2.0 * math.expm1(-0.2))


def test_set_output_and_change_apply_to_the_plant() -> None:
    plant = delayed(0.5)
    plant.set_output(1.0, 4.0)
    assert plant.output(1.0) == 4.0
    plant.change(1.0, PlantSettings(2.0, 1.0, 3.0), 0.4, 0.5)
    assert plant.output(1.0) == 3.0
    plant.set_input(1.0, 1.0)  # it arrives at 1.5 s, and is sampled at 1.8 s
    assert plant.output(2.0) == pytest.approx(3.0 * math.exp(-1.0) - 2.0 * math.expm1(-0.2))
