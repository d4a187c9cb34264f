"""A motor as a board sees it: steps of the pulse width, counts of the encoder."""

import math

import pytest

from first_order_sys_sim.first_order_plant import PlantSettings
from serial_link.device.motor import PWM_STEPS, Motor

SETTINGS = PlantSettings(gain=10.0, time_constant=0.05, max_output=8.0, min_input=0.05)


def motor() -> Motor:
    return Motor(SETTINGS, 1000, began_at=100.0)


@pytest.mark.parametrize(
    "share, pwm",
    [(0.0, 0), (0.5, 128), (1.0, 255), (7.0, 255), (-3.0, -255), (0.0018, 0), (0.004, 1)],
)
def test_pulse_width_has_255_steps_in_each_direction(share: float, pwm: int) -> None:
    turning = motor()
    turning.drive(100.0, share)
    assert turning.pwm == pwm and PWM_STEPS == 255


def test_angle_is_that_of_the_step_response() -> None:
    turning = motor()
    turning.drive(100.0, 0.6)
    target, seconds = 10.0 * 153 / 255, 0.5
    angle = target * (seconds - 0.05 * (1.0 - math.exp(-seconds / 0.05)))
    counts = [turning.counts(100.0 + 0.01 * step) for step in range(1, 51)]
    assert counts == sorted(counts)
    assert counts[-1] == pytest.approx(angle * 1000 / (2.0 * math.pi), abs=1.0)


def test_dead_zone_and_greatest_speed() -> None:
    turning = motor()
    turning.drive(100.0, 12 / 255)
    assert turning.counts(101.0) == 0
    turning.drive(101.0, -1.0)
    before = turning.counts(102.0)
    gone = turning.counts(103.0) - before
    assert turning.speed_of(gone, 1.0) == pytest.approx(-8.0, abs=0.01)


def test_speed_is_quantised_to_one_count() -> None:
    turning = motor()
    assert turning.speed_of(3, 0.01) == pytest.approx(3 * 2.0 * math.pi / 1000 / 0.01)
    assert turning.speed_of(0, 0.01) == 0.0


def test_encoder_is_set_to_zero_and_the_motor_turns_on() -> None:
    turning = motor()
    turning.drive(100.0, 1.0)
    assert turning.counts(101.0) > 1000
    turning.zero(101.0)
    assert turning.counts(101.0) == 0
    assert turning.counts(102.0) == pytest.approx(8000 / (2.0 * math.pi), abs=2)
    turning.zero(102.0)
    assert turning.counts(102.0) == 0


def test_angle_up_to_a_change_is_that_of_the_input_and_motor_before() -> None:
    turning = motor()
    turning.drive(100.0, 1.0)
    turning.drive(100.02, 0.0)
    angle = 10.0 * (0.02 - 0.05 * (1.0 - math.exp(-0.02 / 0.05)))
    assert turning.counts(100.02) == pytest.approx(angle * 1000 / (2.0 * math.pi), abs=1.0)
    turning = motor()
    turning.drive(100.0, 1.0)
    turning.change(101.0, SETTINGS._replace(max_output=4.0))
    assert turning.counts(101.0) == pytest.approx(8.0 * 1000 / (2.0 * math.pi), rel=0.1)


def test_changed_motor_and_long_pause() -> None:
    turning = motor()
    turning.drive(100.0, 1.0)
    turning.change(101.0, SETTINGS._replace(max_output=4.0))
    before = turning.counts(102.0)
    assert turning.counts(1002.0) - before == pytest.approx(
        4.0 * 900 * 1000 / (2 * math.pi), rel=1e-3
    )
