"""Tests of the PID controller: against scipy's simulation, and at its limits."""

import math
from typing import List, Tuple

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from pid_control.controller.pid import (
    BACK_CALCULATION,
    CLAMPING,
    MANUAL,
    NONE,
    PI,
    PID,
    P,
    Pid,
    PidSettings,
    Terms,
)

GAIN, TIME_CONSTANT, DT = 13.1, 0.04, 0.01
#: Wide limits, so that nothing is cut off.
FREE = PidSettings(PID, 0.08, 1.5, 0.0005, 0.02, output_min=-1e9, output_max=1e9)

gains = st.floats(0.0, 0.1)
set_points = st.lists(st.floats(-10.0, 10.0), min_size=2, max_size=60)


def close_loop(settings: PidSettings, wanted: List[float]) -> List[float]:
    """Return the measurements of a motor driven by a law, with each input held for DT."""
    law, measurement = Pid(settings), 0.0
    decay = math.exp(-DT / TIME_CONSTANT)
    measurements = []
    for number, set_point in enumerate(wanted):
        measurements.append(measurement)
        held = law.update(set_point, measurement, DT if number else 0.0).output
        measurement = GAIN * held + (measurement - GAIN * held) * decay
    return measurements


def reference(settings: PidSettings, wanted: List[float]) -> List[float]:
    """Return the same from scipy: the loop as one linear system, of transfer functions in z.

    u = (b kp + kf + I) r - (kp + I + D) y with I = ki dt z / (z - 1) and
    D = kd (z - 1) / ((tf + dt) z - tf); y = G u with G the held motor.
    """
    decay = math.exp(-DT / TIME_CONSTANT)
    motor = numpy.poly1d([GAIN * (1.0 - decay)]), numpy.poly1d([1.0, -decay])
    one = numpy.poly1d([1.0, -1.0])
    ki, kd = settings.ki * DT, settings.kd
    slow = numpy.poly1d([settings.filter_time + DT, -settings.filter_time])
    integral = numpy.poly1d([ki, 0.0])
    weighted = settings.set_point_weight * settings.kp + settings.feed_forward
    ahead = (weighted * one + integral) * slow
    back = (settings.kp * one + integral) * slow + kd * one * one
    below = one * slow
    top = motor[0] * ahead
    bottom = motor[1] * below + motor[0] * back
    numerator = numpy.concatenate([numpy.zeros(len(bottom.c) - len(top.c)), top.c])
    response = signal.lfilter(numerator / bottom.c[0], bottom.c / bottom.c[0], wanted)
    return [float(value) for value in response]


@given(gains, st.floats(0.0, 2.0), st.floats(0.0, 1e-3), st.floats(0.0, 0.1), set_points)
def test_loop_responds_as_scipy_says(
    kp: float, ki: float, kd: float, filter_time: float, wanted: List[float]
) -> None:
    # scipy's system is at rest before the first sample, and knows no step before it.
    settings = FREE._replace(kp=kp, ki=ki, kd=kd, filter_time=filter_time, feed_forward=0.02)
    wanted = [0.0, *wanted]
    assert close_loop(settings, wanted) == pytest.approx(reference(settings, wanted), abs=1e-9)


@pytest.mark.parametrize("weight", [0.0, 0.5, 1.0])
def test_weighted_set_point_responds_as_scipy_says(weight: float) -> None:
    settings = FREE._replace(set_point_weight=weight)
    wanted = [0.0] + [1.0] * 100
    got = close_loop(settings, wanted)
    assert got == pytest.approx(reference(settings, wanted), abs=1e-9)
    assert got[-1] == pytest.approx(1.0, abs=1e-3)


def test_p_controller_has_expected_steady_error() -> None:
    # Of a first-order plant: y = K kp / (1 + K kp) r.
    got = close_loop(FREE._replace(mode=P, kp=0.1), [1.0] * 200)
    assert got[-1] == pytest.approx(1.31 / 2.31, rel=1e-9)


def test_derivative_ignores_set_point() -> None:
    law = Pid(FREE._replace(kp=0.0, ki=0.0, filter_time=0.0))
    law.update(0.0, 0.0, 0.0)
    assert law.update(1000.0, 0.0, DT).output == 0.0
    assert law.update(1000.0, 0.5, DT).derivative == pytest.approx(-0.0005 * 0.5 / DT)


@given(st.lists(st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0)), max_size=30))
def test_output_stays_within_its_limits(samples: List[Tuple[float, float]]) -> None:
    for anti_windup in (CLAMPING, BACK_CALCULATION, NONE):
        law = Pid(FREE._replace(output_min=-0.25, output_max=1.0, anti_windup=anti_windup))
        for set_point, measurement in samples:
            terms = law.update(set_point, measurement, DT)
            assert -0.25 <= terms.output <= 1.0
            assert terms.unlimited == pytest.approx(sum(terms[:4]), abs=1e-9)


def time_at_limit(anti_windup: str) -> float:
    """Return for how long the output stays at its limit after 2 s out of reach, s."""
    settings = PidSettings(PI, 0.08, 1.5, anti_windup=anti_windup, tracking_time=0.1)
    law = Pid(settings)
    outputs = [law.update(20.0, 13.0, DT).output for _ in range(200)]
    assert outputs[100:] == [1.0] * 100
    after = 0
    while law.update(5.0, 13.0, DT).output == 1.0:
        after += 1
    return after * DT


def test_integral_does_not_wind_up() -> None:
    assert time_at_limit(CLAMPING) == 0.0
    assert time_at_limit(BACK_CALCULATION) < 0.1
    assert time_at_limit(NONE) > 1.0


def test_clamping_lets_the_integral_return_while_the_output_is_limited() -> None:
    law = Pid(PidSettings(PI, 0.0, 1.0, feed_forward=1.0))
    for number in range(10):
        terms = law.update(5.0, 6.0, DT)
        assert terms.output == 1.0 and terms.integral == pytest.approx(-DT * (number + 1))


def test_back_calculation_follows_with_its_time_constant() -> None:
    law = Pid(PidSettings(PI, 0.0, 1.0, anti_windup=BACK_CALCULATION, tracking_time=0.5))
    # In the steady state the excess v - 1 decays as fast as the error of 1 adds to it.
    terms = [law.update(1.0, 0.0, DT) for _ in range(1000)][-1]
    assert terms.unlimited - 1.0 == pytest.approx(DT / -math.expm1(-DT / 0.5), rel=1e-6)


@pytest.mark.parametrize(
    "change",
    [
        dict(kp=0.02),
        dict(ki=0.3),
        dict(kd=0.01),
        dict(set_point_weight=0.0),
        dict(feed_forward=0.05),
        dict(mode=PID),
        dict(kp=0.5, ki=4.0, mode=PID),
        dict(dead_zone=0.05),
        dict(dead_zone=0.05, output_max=0.8),
    ],
)
def test_change_of_settings_makes_no_jump(change: dict) -> None:
    settings = PidSettings(PI, 0.08, 1.5, 0.001)
    law = Pid(settings)
    for _ in range(30):
        before = law.update(5.0, 4.0, DT).output
    law.change(settings._replace(**change))
    after = law.update(5.0, 4.0, DT).output
    assert after == pytest.approx(before, abs=1e-9)
    assert law.update(5.0, 4.0, DT).output > after  # and it continues


def test_change_to_a_lower_limit_starts_at_that_limit() -> None:
    settings = PidSettings(PI, 0.08, 1.5)
    law = Pid(settings)
    for _ in range(100):
        law.update(5.0, 4.0, DT)
    law.change(settings._replace(output_max=0.3))
    assert law.update(5.0, 4.0, DT).unlimited == pytest.approx(0.3)


@pytest.mark.parametrize("anti_windup", [CLAMPING, BACK_CALCULATION])
def test_change_of_ki_to_0_holds_the_integral(anti_windup: str) -> None:
    settings = PidSettings(PI, 0.08, 1.5, anti_windup=anti_windup)
    law = Pid(settings)
    for _ in range(30):
        before = law.update(5.0, 4.0, DT).output
    law.change(settings._replace(ki=0.0))
    for speed in (*[-20.0] * 30, *[4.0] * 30):  # first at the limit
        after = law.update(5.0, speed, DT).output
    assert after == pytest.approx(before, abs=1e-9)
    law.change(settings)
    assert law.update(5.0, 4.0, DT).output == pytest.approx(before, abs=1e-9)


def test_ki_of_0_from_the_start_keeps_no_integral() -> None:
    law = Pid(PidSettings(PI, 0.08, 0.0))
    law.resume(0.5)
    assert law.update(5.0, 4.0, 0.0).output == pytest.approx(0.08)


@pytest.mark.parametrize("dead_zone", [0.0, 0.05])
def test_from_manual_to_automatic_without_a_jump(dead_zone: float) -> None:
    settings = PidSettings(MANUAL, 0.08, 1.5, manual_output=0.4, dead_zone=dead_zone)
    law = Pid(settings)
    assert law.update(5.0, 4.0, DT).output == 0.4
    law.change(settings._replace(mode=PI))
    assert law.update(5.0, 4.0, DT).output == pytest.approx(0.4, abs=1e-9)
    assert law.update(5.0, 4.0, DT).output == pytest.approx(0.4 + 1.5 * DT, abs=1e-9)


def test_manual_output_is_limited_too() -> None:
    law = Pid(PidSettings(MANUAL, manual_output=3.0))
    assert law.update(1.0, 0.0, DT) == Terms(0.0, 0.0, 0.0, 0.0, 3.0, 1.0)


def test_resume_continues_from_output_also_at_a_limit() -> None:
    law = Pid(PidSettings(PI, 0.08, 1.5, dead_zone=0.05))
    law.resume(1.0)
    assert law.update(5.0, 0.0, 0.0).output == pytest.approx(1.0)
    assert law.update(5.0, 6.0, DT).output < 1.0


def test_resume_is_not_forgotten_by_a_change_before_the_next_measurement() -> None:
    law = Pid(PidSettings(PI, 0.08, 1.5))
    law.resume(0.5)
    law.change(PidSettings(PI, 0.1, 1.5))
    assert law.update(5.0, 4.0, 0.0).output == pytest.approx(0.5)


def test_change_to_a_higher_limit_continues_from_the_lower_one() -> None:
    settings = PidSettings(PI, 0.08, 1.5, output_min=-0.25, output_max=0.5, anti_windup=NONE)
    for sign, limit in ((1.0, 0.5), (-1.0, -0.25)):
        law = Pid(settings)
        for _ in range(100):
            assert law.update(5.0 * sign, 0.0, DT).unlimited != limit
        law.change(settings._replace(output_min=-9.0, output_max=9.0))
        assert law.update(5.0 * sign, 0.0, DT).output == pytest.approx(limit)


def test_resume_forgets_the_derivative() -> None:
    law = Pid(FREE)
    for speed in (1.0, 1.5):
        assert law.update(5.0, speed, DT).derivative <= 0.0
    law.resume(0.5)
    assert law.update(5.0, 4.0, 0.0).derivative == 0.0


def test_manual_mode_ends_without_a_derivative_of_the_time_before() -> None:
    law = Pid(FREE)
    law.update(5.0, 1.0, 0.0)
    law.change(FREE._replace(mode=MANUAL))
    law.update(5.0, 4.0, DT)
    law.change(FREE)
    assert law.update(5.0, 4.0, DT).derivative == 0.0


@pytest.mark.parametrize("mode", [P, PI])
def test_mode_without_derivative_has_none_left(mode: str) -> None:
    law = Pid(FREE)
    for speed in (1.0, 1.5):
        assert law.update(5.0, speed, DT).derivative <= 0.0
    law.change(FREE._replace(mode=mode))
    assert law.update(5.0, 2.0, DT).derivative == 0.0


def test_mode_without_integral_clears_it() -> None:
    settings = PidSettings(PI, 0.08, 1.5)
    law = Pid(settings)
    for _ in range(30):
        law.update(5.0, 4.0, DT)
    law.change(settings._replace(mode=P))
    for _ in range(2):
        assert law.update(5.0, 4.0, DT)[1:] == pytest.approx((0.0, 0.0, 0.0, 0.08, 0.08))


def test_reset_restores_initial_state() -> None:
    law = Pid(FREE)
    first = law.update(5.0, 1.0, 0.0)
    for _ in range(10):
        law.update(5.0, 2.0, DT)
    law.change(FREE)
    law.reset()
    assert law.update(5.0, 1.0, 0.0) == first


def test_dead_zone_compensation_is_smooth_around_zero() -> None:
    settings = PidSettings(P, 1.0, dead_zone=0.05)
    law = Pid(settings)
    assert law.update(0.2, 0.0, 0.0).output == pytest.approx(0.25)
    assert law.update(-0.2, 0.0, DT).output == pytest.approx(-0.25)
    assert law.update(0.001, 0.0, DT).output == pytest.approx(0.011)
    assert law.update(0.0, 0.0, DT).output == 0.0


@given(st.floats(-0.9, 0.9), st.floats(0.001, 0.2))
def test_uncompensated_inverts_compensated(output: float, dead_zone: float) -> None:
    settings = PidSettings(dead_zone=dead_zone)
    assert settings.uncompensated(settings.compensated(output)) == pytest.approx(output, abs=1e-12)
