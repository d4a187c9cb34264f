"""The shapes against scipy, closed forms and the course's own echo."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from basic_comms.signals import waveforms
from basic_comms.signals.waveforms import TWO_PI

phases = st.floats(-1e4, 1e4)
duties = st.floats(0.01, 0.99)
symmetries = st.floats(0.0, 1.0)


def far_from_jumps(phase, *jumps):
    """Return whether a phase is away from positions, in turns, where references may differ."""
    turns = phase / TWO_PI
    return all(abs((turns - jump + 0.5) % 1.0 - 0.5) > 1e-6 for jump in (0.0,) + jumps)


def as_float32(value):
    return struct.unpack("f", struct.pack("f", value))[0]


@pytest.mark.parametrize(
    "time_x, signal_y",
    [
        (42.62652254104614, -1.4285545349121094),
        (42.67646789550781, -1.790870189666748),
        (42.7266628742218, -1.978720784187317),
        (42.776490926742554, -1.9721505641937256),
        (42.82658338546753, -1.7723089456558228),
    ],
)
def test_the_samples_shown_by_the_course_are_reproduced_to_the_last_bit_of_float32(
    time_x, signal_y
):
    assert as_float32(2.0 * waveforms.sine(6.2832 * time_x)) == signal_y


@given(phases, duties)
def test_square_equals_scipy(phase, duty):
    if far_from_jumps(phase, duty):
        assert waveforms.square(phase, duty) == signal.square(phase, duty)


@given(phases, duties)
def test_pulse_is_the_upper_half_of_the_square(phase, duty):
    assert waveforms.pulse(phase, duty) == (waveforms.square(phase, duty) + 1.0) / 2.0


@given(phases, symmetries)
def test_sawtooth_equals_scipy(phase, symmetry):
    if far_from_jumps(phase, symmetry):
        expected = signal.sawtooth(phase, symmetry)
        slope = 2.0 / min(x for x in (symmetry, 1.0 - symmetry) if x > 0.0)
        assert waveforms.sawtooth(phase, symmetry) == pytest.approx(expected, abs=1e-12 * slope)


@given(phases)
def test_triangle_equals_scipy_shifted_in_line_with_the_sine(phase):
    expected = signal.sawtooth(phase + math.pi / 2.0, 0.5)
    assert waveforms.triangle(phase) == pytest.approx(expected, abs=1e-8)


@given(phases)
def test_triangle_equals_its_closed_form(phase):
    expected = 2.0 / math.pi * math.asin(math.sin(phase))
    assert waveforms.triangle(phase) == pytest.approx(expected, abs=1e-7)


@given(phases, duties, symmetries)
def test_every_shape_stays_within_one(phase, duty, symmetry):
    values = (
        waveforms.sine(phase),
        waveforms.square(phase, duty),
        waveforms.pulse(phase, duty),
        waveforms.triangle(phase),
        waveforms.sawtooth(phase, symmetry),
    )
    assert all(-1.0 <= value <= 1.0 for value in values)


@given(phases)
def test_cycle_fraction_is_below_one_also_just_before_zero(phase):
    assert 0.0 <= waveforms.cycle_fraction(phase) < 1.0
    assert waveforms.cycle_fraction(-1e-20) == 0.0


@pytest.mark.parametrize("hertz, rate", [(1, 10), (5, 100), (7, 70), (3, 30), (50, 1000)])
def test_edges_that_fall_on_samples_always_fall_on_the_same_side(hertz, rate):
    period = rate // hertz
    phases_on_grid = [TWO_PI * hertz * (n / rate) for n in range(100 * period)]
    square = [waveforms.square(phase) for phase in phases_on_grid]
    assert square == ([1.0] * (period // 2) + [-1.0] * (period // 2)) * 100
    pulse = [waveforms.pulse(phase) for phase in phases_on_grid]
    assert pulse == ([1.0] * (period // 2) + [0.0] * (period // 2)) * 100
    sawtooth = [waveforms.sawtooth(phase) for phase in phases_on_grid]
    assert sawtooth == pytest.approx([2.0 * n / period - 1.0 for n in range(period)] * 100)


def test_step_happens_at_its_time():
    assert [waveforms.step(time, 1.5) for time in (0.0, 1.4999, 1.5, 9.0)] == [0.0, 0.0, 1.0, 1.0]


def test_ramp_rises_with_its_slope_until_the_limit():
    assert [waveforms.ramp(time, 0.5, 2.0) for time in (0, 1, 2, 4, 9)] == [0, 0.25, 0.5, 1, 1]
    assert [waveforms.ramp(time, -0.5, 2.0) for time in (0, 1, 9)] == [0, -0.25, -1]
    assert waveforms.ramp(0.0, 0.5, 0.0) == 0.0


@given(st.floats(0.0, 1e9), st.floats(-1e6, 1e6), st.floats(0.0, 1e6))
def test_ramp_stays_within_one(time, slope, limit):
    assert -1.0 <= waveforms.ramp(time, slope, limit) <= 1.0
