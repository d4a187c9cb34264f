"""Formulas over time: filters, means and slopes against exact values."""

import math
from typing import List, Tuple

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.formulas.signals import (
    Signal,
    averaged,
    delayed,
    extreme,
    low_passed,
    slope,
)
from topic_scope.timing.nanoseconds import NS, array_to_ns, to_ns


def sampled(times: numpy.ndarray, values: numpy.ndarray, longest: float = math.inf) -> Signal:
    at = array_to_ns(times)
    return Signal(at, values, at, longest)


@given(st.floats(0.1, 10.0), st.floats(0.1, 10.0))
@settings(max_examples=30, deadline=None)
def test_a_sine_behind_a_low_pass_is_lower_and_later_as_theory_says(
    ratio: float, cutoff: float
) -> None:
    turn = 2 * math.pi * ratio * cutoff
    times = numpy.arange(0.0, 5.0 / cutoff, 1.0 / (ratio * cutoff * 200.0)).round(9)
    found = low_passed(sampled(times, numpy.sin(turn * times)), cutoff)
    truth = numpy.sin(turn * times - math.atan(ratio)) / math.hypot(1.0, ratio)
    settled = times > 20.0 / (2 * math.pi * cutoff)
    assert settled.sum() > 30
    assert numpy.abs(found.values - truth)[settled].max() < 2e-4


def one_by_one(times: numpy.ndarray, values: numpy.ndarray, cutoff: float) -> numpy.ndarray:
    """Return the same low-pass, sample by sample."""
    found = [values[0]]
    for index in range(1, len(times)):
        ratio = 2 * math.pi * cutoff * (times[index] - times[index - 1])
        rise = values[index] - values[index - 1]
        if ratio == 0.0:
            found.append(found[-1])
            continue
        lag = rise / ratio  # behind a ramp, after which the rest dies away
        found.append(values[index] - lag + (found[-1] - values[index - 1] + lag) * math.exp(-ratio))
    return numpy.array(found)


@given(
    st.lists(st.tuples(st.floats(1e-4, 2.0), st.floats(-5.0, 5.0)), min_size=1, max_size=60),
    st.floats(0.02, 1e4),
)
@settings(max_examples=30, deadline=None)
def test_low_pass_equals_the_sample_by_sample_recurrence(
    samples: List[Tuple[float, float]], cutoff: float
) -> None:
    times = numpy.cumsum([step for step, _ in samples]).round(9)
    values = numpy.array([value for _, value in samples])
    found = low_passed(sampled(times, values), cutoff).values
    assert found == pytest.approx(one_by_one(times, values, cutoff), abs=1e-6)


def test_low_pass_restarts_after_a_gap_and_after_nan() -> None:
    times = numpy.array([0.0, 1.0, 2.0, 9.0, 10.0, 11.0, 12.0])
    values = numpy.array([0.0, 0.0, 0.0, 5.0, 5.0, math.nan, 8.0])
    found = low_passed(sampled(times, values, 3.0), 0.02).values
    assert found[:5].tolist() == [0.0, 0.0, 0.0, 5.0, 5.0]
    assert math.isnan(found[5]) and found[6] == 8.0
    nothing = sampled(times[:1], numpy.array([math.nan]))
    assert math.isnan(low_passed(nothing, 1.0).values[0])


def test_mean_ignores_nan() -> None:
    times = numpy.array([0.0, 1.0, 2.0, 3.0, 4.0])
    values = numpy.array([1e9, 1e9 + 2.0, math.nan, 1e9 + 4.0, 1e9])
    found = averaged(sampled(times, values), 2 * NS).values - 1e9
    assert found[[0, 1, 3, 4]] == pytest.approx([0.0, 1.0, 4.0, 2.0], abs=1e-6)
    assert math.isnan(found[2])
    with numpy.errstate(all="raise"):
        assert math.isnan(averaged(sampled(times[:1], values[2:3]), NS).values[0])


def test_a_slope_is_in_the_middle_of_two_samples_and_not_across_a_gap() -> None:
    times, values = numpy.array([0.0, 1.0, 3.0, 3.0, 9.0]), numpy.array([0.0, 2.0, 0.0, 7.0, 7.0])
    found = slope(sampled(times, values, 2.5))
    assert (found.times / NS).tolist() == [0.5, 2.0, 3.0, 6.0]
    assert found.values[:2].tolist() == [2.0, -1.0] and numpy.isnan(found.values[2:]).all()
    assert (found.received / NS).tolist() == times[1:].tolist()
    assert not len(slope(sampled(times[:1], values[:1])).times)


def test_a_signal_is_known_between_its_samples_and_not_beyond_them_or_in_a_gap() -> None:
    signal = sampled(numpy.array([0.0, 1.0, 5.0]), numpy.array([0.0, 10.0, 50.0]), 2.0)
    found = signal.at(array_to_ns(numpy.array([-1.0, 0.0, 0.5, 1.0, 3.0, 5.0, 6.0])))
    assert found[[1, 2, 3, 5]].tolist() == [0.0, 5.0, 10.0, 50.0]
    assert numpy.isnan(found[[0, 4, 6]]).all()
    assert signal.between(0, NS).times.tolist() == [0, NS] and signal.between(0, NS).longest == 2.0
    assert delayed(signal, 2 * NS).times.tolist() == [2 * NS, 3 * NS, 7 * NS]


@given(
    st.lists(st.tuples(st.floats(0.01, 1.0), st.floats(-5.0, 5.0)), min_size=2, max_size=40),
    st.floats(0.0, 3.0),
)
@settings(max_examples=30, deadline=None)
def test_the_highest_and_the_lowest_value_around_a_time(
    samples: List[Tuple[float, float]], seconds: float
) -> None:
    times = numpy.cumsum([step for step, _ in samples]).round(9)
    values = numpy.array([value for _, value in samples])
    moments, seconds = numpy.linspace(times[0], times[-1], 23).round(9), round(seconds, 9)
    reach, at = to_ns(seconds), array_to_ns(moments)
    highest = extreme(sampled(times, values), at, reach, numpy.maximum)
    lowest = extreme(sampled(times, values), at, reach, numpy.minimum)
    for moment, high, low in zip(moments, highest, lowest):
        ends = round(moment - seconds, 9), round(moment + seconds, 9)
        if ends[0] < times[0] or ends[1] > times[-1]:
            assert math.isnan(high) and math.isnan(low)
            continue
        # At the ends of the span, and at the corners of the line within it.
        corners = values[(times >= ends[0]) & (times <= ends[1])].tolist()
        around = [*numpy.interp(ends, times, values).tolist(), *corners]
        assert high == pytest.approx(max(around), abs=1e-9)
        assert low == pytest.approx(min(around), abs=1e-9)
