"""Measurements of steps and waves against closed forms."""

import math
from typing import List

import numpy
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from topic_scope.analysis import waves
from topic_scope.analysis.measurement import Measurement
from topic_scope.analysis.steps import step_of
from topic_scope.analysis.waveform import measure_waveform, phase

EPOCH = 1.7e9
TIMES = numpy.arange(-0.5, 10.0, 0.002)

scales = st.floats(1e-3, 1e6) | st.floats(-1e6, -1e-3)


def step(damping: float) -> numpy.ndarray:
    """Return the step response of a second-order system with 2 rad/s."""
    omega, times = 2.0, numpy.maximum(TIMES, 0.0)
    damped = omega * math.sqrt(1 - damping**2)
    values = numpy.cos(damped * times) + damping * omega / damped * numpy.sin(damped * times)
    return 1.0 - numpy.exp(-damping * omega * times) * values


@settings(max_examples=30)
@given(st.floats(0.05, 0.8), scales, st.floats(-1e3, 1e3))
def test_a_step_of_first_order(tau: float, height: float, low: float) -> None:
    values = low + height * (1.0 - numpy.exp(-numpy.maximum(TIMES, 0.0) / tau))
    found = measure_waveform(EPOCH + TIMES, values)
    assert found["rise"].value == pytest.approx(tau * math.log(9.0), abs=2e-3)
    # From leaving the initial level by 2 % to staying within 2 % of the final level.
    assert found["settling"].value == pytest.approx(tau * math.log(0.98 / 0.02), abs=4e-3)
    assert found["overshoot"].value == pytest.approx(0.0, abs=0.1)
    assert found["duty"].value is None


@settings(max_examples=30)
@given(st.floats(0.4, 0.9), scales)
def test_a_step_of_second_order_overshoots(damping: float, height: float) -> None:
    found = measure_waveform(EPOCH + TIMES, height * step(damping))
    expected = 100.0 * math.exp(-math.pi * damping / math.sqrt(1.0 - damping**2))
    assert found["overshoot"].value == pytest.approx(expected, abs=0.2)


@settings(max_examples=30)
@given(st.floats(0.6, 20.0), st.floats(0.0, 6.28), scales)
def test_rise_time_of_a_sine(frequency: float, at: float, peak: float) -> None:
    found = measure_waveform(EPOCH + TIMES, peak * numpy.sin(2 * math.pi * frequency * TIMES + at))
    assert found["rise"].value == pytest.approx(math.asin(0.8) / math.pi / frequency, rel=0.02)
    assert found["duty"].value == pytest.approx(50.0, abs=0.5)
    assert found["settling"].value is None


@pytest.mark.parametrize("error", [-0.01, 0.01])
def test_uncertainty_of_a_rise_time_covers_that_of_the_frequency(error: float) -> None:
    wave = waves.wave_of(TIMES, (TIMES % 0.5 < 0.2) * 1.0, Measurement(2.0 + error, abs(error)))
    assert wave is not None
    found = waves.rise(wave)
    assert found.value is not None and found.value - found.uncertainty < 0.002


@settings(max_examples=30)
@given(st.floats(0.1, 0.9), scales, st.floats(-1e3, 1e3))
def test_a_pulse_train_has_its_duty(duty: float, height: float, low: float) -> None:
    values = low + height * (TIMES % 0.5 < 0.5 * duty)
    expected = duty if height > 0 else 1.0 - duty
    found = measure_waveform(EPOCH + TIMES, values)
    assert found["duty"].value == pytest.approx(100.0 * expected, abs=0.5)


@settings(max_examples=30)
@given(st.floats(0.1, 0.9), st.floats(0.0, 0.5))
def test_nothing_is_measured_across_a_gap(duty: float, at: float) -> None:
    values = ((TIMES - at) % 0.5 < 0.5 * duty).astype(float)
    kept = (TIMES < 3.0) | (TIMES > 6.2)
    found = measure_waveform(EPOCH + TIMES[kept], values[kept], longest=0.1)
    assert found["duty"].value == pytest.approx(100.0 * duty, abs=0.5)
    assert found["rise"].value == pytest.approx(0.8 * 0.002, abs=1e-4)


@settings(max_examples=30)
@given(st.floats(0.6, 20.0), st.floats(-179.0, 179.0), scales, st.integers(0, 2**32 - 1))
def test_phase_is_measured_with_any_sampling(
    frequency: float, degrees: float, mean: float, seed: int
) -> None:
    random = numpy.random.RandomState(seed)
    samples = []
    for angle in (degrees, 0.0):
        times = numpy.sort(random.uniform(0.0, 5.0, 2000))
        turns = 2 * math.pi * frequency * times + math.radians(angle)
        samples.append((EPOCH + times, mean + abs(mean) * numpy.sin(turns)))
    found = phase(*samples).value
    assert found is not None
    assert abs((found - degrees + 180.0) % 360.0 - 180.0) < 0.5


def test_phase_is_measured_with_missing_samples() -> None:
    times = numpy.arange(0.0, 10.0, 0.01)
    there = (times < 3.3) | (times > 5.1)
    late, first = (
        (times[there], numpy.sin(2.0 * math.pi * times[there] - angle)) for angle in (0.5, 0.0)
    )
    assert phase(late, first, 0.05).value == pytest.approx(-math.degrees(0.5), abs=0.5)


def test_no_phase_without_a_wave() -> None:
    wave, flat = (TIMES, numpy.sin(9.0 * TIMES)), (TIMES, numpy.ones(len(TIMES)))
    reasons = [phase(*pair).reason for pair in ((wave, flat), (flat, wave))]
    assert reasons[0] == "the reference has no frequency: the trace is constant"
    assert reasons[1] == "no component at the frequency of the reference"
    assert phase((TIMES[:2], TIMES[:2]), wave).reason == "too few samples"


@settings(max_examples=30)
@given(st.lists(st.floats() | st.sampled_from([0.0, 1.0, 2.0]), max_size=60), st.integers(0, 20))
@example([-1.2e308, 0.0, -1.2e308, -1.2e308, 0.0], 0)  # whose sum is not finite
@example([0.0, 2.0, 0.0, 2.0, 0.0, 2.0], 4)
def test_anything_is_measured_and_the_result_is_finite(values: List[float], still: int) -> None:
    # A paused simulation repeats its stamp.
    times = numpy.maximum(numpy.arange(float(len(values))), still)
    numbers = numpy.array(values, float)
    found = {**measure_waveform(times, numbers), "phase": phase((times, numbers), (times, numbers))}
    for value, uncertainty, reason in found.values():
        assert bool(reason) == (value is None)
        assert math.isfinite(value or 0.0) and 0.0 <= uncertainty < math.inf


@pytest.mark.parametrize("counts", [20, 100, 1000])
def test_overshoot_uncertainty_includes_quantisation(counts: int) -> None:
    """Second-order response, quantised by an encoder of few counts."""
    times = numpy.arange(0.0, 12.0, 0.01)
    since = numpy.maximum(times - 1.0, 0.0)
    exact = 1.0 - numpy.exp(-0.8 * since) * (
        numpy.cos(3.0 * since) + 0.8 / 3.0 * numpy.sin(3.0 * since)
    )
    truth = 100.0 * (exact.max() - 1.0)
    for shift in (0.0, 0.3, 0.5):
        values = numpy.floor(exact * counts + shift)
        found = measure_waveform(EPOCH + times, values)["overshoot"]
        if found.value is None:
            assert found.reason
            continue
        assert abs(found.value - truth) <= found.uncertainty
        assert 100.0 / counts <= found.uncertainty <= 400.0 / counts + 1.0


def test_step_that_ends_shortly_after_it_settles_is_not_measured() -> None:
    times = numpy.linspace(0.0, 1.0, 1001)
    assert step_of(times, numpy.clip((times - 0.3) / 0.5, 0.0, 1.0)) == (
        "the final level is not held for long enough"
    )
