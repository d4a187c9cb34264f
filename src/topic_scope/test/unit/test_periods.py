"""Frequency of periodic traces; noise and signals of changing pace have none."""

import math
import time
from typing import Callable, List, Optional

import numpy
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from topic_scope.analysis.periods import NO_PERIOD, NOT_ENOUGH, STANDS, TOO_SHORT, frequency

seeds = st.integers(0, 2**32 - 1)


def hertz_of(
    times: numpy.ndarray, values: numpy.ndarray, longest: float = math.inf
) -> "Optional[float]":
    """Return the frequency, after checking its uncertainty."""
    finite = numpy.isfinite(values)
    found = frequency(times[finite], values[finite], longest)
    assert found.value is None or found.uncertainty < 0.3 * found.value
    return found.value


@settings(max_examples=30)
@given(st.floats(0.5, 20.0), st.floats(0.0, 6.28), st.floats(-3.0, 3.0))
def test_a_sine_has_its_frequency(hertz: float, angle: float, mean: float) -> None:
    times = 1.7e9 + numpy.arange(0, math.ceil(10 * hertz) / hertz, 0.002)
    values = mean + numpy.sin(2 * math.pi * hertz * times + angle)
    assert hertz_of(times, values) == pytest.approx(hertz, rel=2e-3)


@settings(max_examples=30)
@given(st.floats(100.0, 2000.0), st.floats(0.0, 1.0), st.floats(1e-3, 1e3), st.floats(-3.0, 3.0))
@example(100.0, 0.0, 1.0, 0.0)
def test_two_periods_determine_the_frequency_at_any_start(
    rate: float, begin: float, peak: float, mean: float
) -> None:
    # In 2 s, minus the samples that have not arrived yet.
    times = 1.7e9 + begin + numpy.arange(0.0, 1.99, 1.0 / rate)
    values = peak * (mean + numpy.sin(2 * math.pi * (times - 1.7e9)))
    assert hertz_of(times, values) == pytest.approx(1.0, abs=1e-4)


@settings(max_examples=60)
@given(
    st.floats(0.5, 20.0),
    st.floats(8.0, 300.0),
    st.floats(3.0, 30.0),
    st.floats(-0.1, 0.1),
    st.floats(0.0, 6.28),
)
@example(2.0, 500.0, 20.0, 0.025, 0.0)
def test_drifting_mean_does_not_change_the_frequency(
    hertz: float, samples: float, periods: float, drift: float, angle: float
) -> None:
    """The drift per period is a fraction of the amplitude."""
    times = 1.7e9 + numpy.arange(int(samples * periods)) / (samples * hertz)
    since = times - 1.7e9
    values = numpy.sin(2 * math.pi * hertz * since + angle) + drift * hertz * since
    found = frequency(times, values)
    assert found.value is None or abs(found.value - hertz) <= found.uncertainty
    if (samples, periods, drift) == (500.0, 20.0, 0.025):
        assert found.value == pytest.approx(2.0, abs=5e-4)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.0])
def test_two_tones_repeat_when_both_do(angle: float) -> None:
    times = 1.7e9 + numpy.arange(0.0, 10.0, 0.01)
    since = times - 1.7e9
    values = numpy.sin(4 * math.pi * since + angle) + 2.0 * numpy.sin(6 * math.pi * since)
    assert hertz_of(times, values) == pytest.approx(1.0, abs=2e-3)


def test_a_tone_beside_a_larger_one_makes_it_not_periodic_enough() -> None:
    times = 1.7e9 + numpy.arange(0.0, 10.0, 0.01)
    since = times - 1.7e9
    values = numpy.sin(2 * math.pi * 2.0 * since) + 2.0 * numpy.sin(2 * math.pi * 3.37 * since)
    assert frequency(times, values) == NOT_ENOUGH


def test_noise_on_a_sine_does_not_change_its_frequency() -> None:
    times = numpy.arange(0.0, 5.0, 0.001)
    values = numpy.sin(2 * math.pi * 3.0 * times)
    values += numpy.random.RandomState(1).uniform(-0.05, 0.05, len(times))
    assert hertz_of(times, values) == pytest.approx(3.0, rel=2e-3)


def test_a_square_wave_has_its_frequency() -> None:
    times = numpy.arange(0.0, 4.0, 0.01)
    values = numpy.where(times % 0.5 < 0.25, 0.0, 5.0)
    assert hertz_of(times, values) == pytest.approx(2.0, rel=1e-2)


@settings(max_examples=30)
@given(st.integers(0, 390), st.integers(20, 300), st.floats(0.5, 2.0))
@example(297, 300, 0.5)  # one rise before the gap, one behind it
@example(305, 264, 0.5113)  # a rise that begins before the gap
def test_periods_across_a_gap_are_ignored(begin: int, length: int, hertz: float) -> None:
    times = 1.7e9 + 0.01 * numpy.arange(1000)
    values = numpy.sin(2 * math.pi * hertz * times)
    for broken in (False, True):  # without samples, or with NaN
        values = numpy.where((numpy.arange(1000) - begin) % 1000 < length, math.nan, values)
        there = slice(None) if broken else numpy.isfinite(values)
        found = hertz_of(times[there], values[there], 0.05)
        assert found == pytest.approx(hertz, rel=2e-3)


@pytest.mark.parametrize(
    "hertz, part", [(45.0, 0.0), (49.0, 0.0), (33.3, 0.0), (45.0, 0.3), (12.3, 0.3)]
)
def test_few_samples_in_a_period_are_enough(hertz: float, part: float) -> None:
    times = 1.7e9 + numpy.arange(1000) / 100.0
    values = numpy.sin(2 * math.pi * hertz * times)
    values += part * numpy.random.RandomState(1).standard_normal(1000)
    assert hertz_of(times, values) == pytest.approx(hertz, abs=0.05)


@pytest.mark.parametrize("crossings, other", [(2, 0.3), (2, 0.8), (2, 3.0), (4, 2.0)])
def test_several_crossings_in_a_period_give_the_whole_period(crossings: int, other: float) -> None:
    times = 1.7e9 + numpy.arange(1000) / 100.0
    turns = 2 * math.pi * 3.0 * times
    values = numpy.sin(turns) + other * numpy.sin(crossings * turns + 1.0)
    assert hertz_of(times, values) == pytest.approx(3.0, rel=1e-3)


@given(seeds, st.integers(10, 2000))
@settings(max_examples=30)
def test_noise_has_no_frequency(seed: int, count: int) -> None:
    values = numpy.random.RandomState(seed).standard_normal(count)
    found = frequency(numpy.arange(count) / 100.0, values)
    assert found.value is None and found in (NO_PERIOD, TOO_SHORT)


@pytest.mark.parametrize("last", [2.0, 5.0, 20.0])
def test_chirp_has_no_frequency(last: float) -> None:
    times = numpy.arange(1000) / 100.0
    values = numpy.sin(2 * math.pi * (times + (last - 1.0) / 20.0 * times**2))
    assert frequency(times, values) == NO_PERIOD


def test_two_tones_have_no_frequency() -> None:
    times = numpy.arange(1000) / 100.0
    values = numpy.sin(2 * math.pi * 3.0 * times) + numpy.sin(2 * math.pi * 7.3 * times)
    assert frequency(times, values) == NO_PERIOD


@pytest.mark.parametrize("values", [[1.0], [2.0, 2.0, 2.0]])
def test_constant_trace_has_no_frequency(values: List[float]) -> None:
    assert frequency(numpy.arange(float(len(values))), numpy.array(values)) == STANDS


def test_one_period_is_too_few() -> None:
    times = numpy.arange(0.0, 10.0, 0.01)
    assert frequency(times, numpy.sin(2 * math.pi * 0.1 * times)) == TOO_SHORT


def test_noise_is_rejected_at_little_cost() -> None:
    """Ten traces at 1 kHz are measured twice a second; sorting calibrates the machine."""
    times = 1.7e9 + numpy.arange(10_000) / 1000.0
    noise = numpy.random.RandomState(1).standard_normal(10_000)
    numbers = noise.tolist()

    def cost(work: Callable[[], object]) -> float:
        costs = []
        for _ in range(20):
            begin = time.process_time()
            work()
            costs.append(time.process_time() - begin)
        return min(costs)

    assert cost(lambda: frequency(times, noise)) < 2.0 * cost(lambda: sorted(numbers))
