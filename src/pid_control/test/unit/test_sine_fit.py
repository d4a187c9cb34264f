"""Tests of the fit of a sine."""

import math
from typing import List, Optional

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pid_control.signal_judging.sine_fit import fit_sine, is_constant, wrapped

AMPLITUDES = st.floats(0.01, 1e3)
FREQUENCIES = st.floats(0.6, 12.0)
PHASES = st.floats(-3.0, 3.0)
OFFSETS = st.floats(-1e3, 1e3)


def grid(duration: float, rate: float) -> List[float]:
    return [index / rate for index in range(int(duration * rate))]


@given(AMPLITUDES, FREQUENCIES, PHASES, OFFSETS)
def test_fit_sine_exact_sine_returns_its_parameters(
    amplitude: float, frequency: float, phase: float, offset: float
) -> None:
    times = grid(15.0, 10.0)
    values = [offset + amplitude * math.sin(frequency * time + phase) for time in times]
    fit = fit_sine(times, values)
    if abs(offset) > 1e4 * amplitude and fit is None:
        return  # rounded to a constant
    assert fit is not None
    assert fit.frequency == pytest.approx(frequency, rel=1e-3)
    assert fit.amplitude == pytest.approx(amplitude, rel=1e-2)
    assert fit.offset == pytest.approx(offset, abs=1e-2 * amplitude + 1e-6 * abs(offset))
    assert abs(wrapped(fit.phase - phase)) < 0.02
    assert fit.distortion < 1e-2
    assert fit.periods == pytest.approx(frequency * times[-1] / (2.0 * math.pi), rel=1e-3)
    assert fit.at(1.0) == pytest.approx(
        offset + amplitude * math.sin(frequency + phase), abs=0.03 * amplitude + 1e-6 * abs(offset)
    )


@pytest.mark.extended
@given(st.integers(0, 2**32 - 1), FREQUENCIES)
def test_fit_sine_noise_is_the_distortion(seed: int, frequency: float) -> None:
    noise = numpy.random.default_rng(seed).normal(0.0, 0.05, 200)
    times = grid(20.0, 10.0)
    values = [math.sin(frequency * time) + one for time, one in zip(times, noise)]
    fit = fit_sine(times, values)
    assert fit is not None
    assert fit.frequency == pytest.approx(frequency, rel=0.02)
    assert 0.035 < fit.distortion < 0.065


@pytest.mark.parametrize(
    ("shape", "distortion"), [(lambda x: math.asin(math.sin(x)), 0.086), (math.tanh, None)]
)
def test_fit_sine_other_shapes_are_distorted(shape: object, distortion: object) -> None:
    times = grid(20.0, 50.0)
    fit = fit_sine(times, [shape(2.0 * time) for time in times])  # type: ignore[operator]
    assert fit is not None
    if distortion is None:
        assert fit.distortion > 0.3
    else:
        assert fit.distortion == pytest.approx(distortion, abs=0.005)


def test_fit_sine_known_frequency_is_kept() -> None:
    times = grid(3.0, 10.0)  # half a period: too short to find it
    fit = fit_sine(times, [2.0 * math.sin(time + 0.3) for time in times], 1.0)
    assert fit is not None
    assert (fit.frequency, fit.amplitude, fit.phase) == pytest.approx((1.0, 2.0, 0.3), rel=1e-6)


@pytest.mark.parametrize("values", [[1.0] * 50, [1.0, 2.0] * 3, [0.0] * 50])
def test_fit_sine_constant_or_short_record_finds_none(values: List[float]) -> None:
    assert fit_sine(grid(len(values) / 10.0, 10.0), values) is None


@pytest.mark.parametrize("frequency", [None, 2.0])
def test_fit_sine_of_a_few_samples_needs_eight(frequency: Optional[float]) -> None:
    times = [0.5 * index for index in range(8)]
    values = [1.0 + 3.0 * math.sin(2.0 * time + 0.3) for time in times]
    assert fit_sine(times[:7], values[:7], frequency) is None
    fit = fit_sine(times, values, frequency)
    assert fit is not None
    assert fit == pytest.approx((3.0, 2.0, 0.3, 1.0, 0.0, 3.5 / math.pi), rel=1e-4, abs=1e-4)


def test_fit_sine_of_a_long_fast_record_finds_its_frequency() -> None:
    """Many frequencies are tried, up to half of the sampling rate; several samples at one time."""
    times = sorted([0.1 * index for index in range(120)] * 2)
    for frequency in (0.6, 13.0, 30.0):
        fit = fit_sine(times, [math.sin(frequency * time + 0.5) for time in times])
        assert fit is not None and fit.frequency == pytest.approx(frequency, rel=1e-4)
        assert fit.distortion < 1e-3


def test_fit_sine_at_one_time_finds_none() -> None:
    assert fit_sine([1.0] * 20, list(map(float, range(20)))) is None


def test_is_constant_ignores_rounding_of_float32() -> None:
    assert is_constant([0.1, float(numpy.float32(0.1))])
    assert is_constant([-5.0, -5.000001]) and is_constant([0.0, 1e-13])
    assert is_constant([0.0, 0.0]) and not is_constant([0.0, 1e-3]) and not is_constant([5.0, 5.1])


def test_wrapped_returns_the_angle_within_half_a_turn() -> None:
    assert wrapped(2.0 * math.pi + 0.5) == pytest.approx(0.5)
    assert wrapped(-4.0) == pytest.approx(2.0 * math.pi - 4.0)
