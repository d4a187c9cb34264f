"""Statistics of a trace."""

import math
from typing import List

import numpy
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from topic_scope.analysis.statistics import measure


@settings(max_examples=30)
@given(st.floats(0.5, 20.0), st.floats(0.0, 6.28), st.floats(1e-3, 1e3), st.floats(-1e3, 1e3))
def test_a_sine_is_measured(frequency: float, phase: float, peak: float, mean: float) -> None:
    times = 1.7e9 + numpy.arange(0, math.ceil(10 * frequency) / frequency, 0.002)
    values = mean + peak * numpy.sin(2 * math.pi * frequency * times + phase)
    result = measure(times, values)
    assert result["rate"] == pytest.approx(500.0)
    assert result["mean"] == pytest.approx(mean, abs=0.02 * peak)
    assert result["max"] == values.max() and result["min"] == values.min()
    assert result["vpp"] == values.max() - values.min() and result["value"] == values[-1]
    assert result["deviation"] == pytest.approx(peak / math.sqrt(2), rel=1e-2)
    assert result["rms"] == pytest.approx(math.hypot(mean, peak / math.sqrt(2)), rel=1e-2)


@settings(max_examples=30)
@given(st.lists(st.floats(), max_size=50), st.sampled_from([1.0, 0.0]))
@example([0.0, 2.0, 0.0, 2.0, 0.0], 0.0)
def test_anything_is_measured_and_the_result_is_finite(values: List[float], step: float) -> None:
    # All stamps are the same in a paused simulation.
    result = measure(step * numpy.arange(len(values)), numpy.array(values, float))
    assert all(number is None or math.isfinite(number) for number in result.values())
    finite = [value for value in values if math.isfinite(value)]
    assert result["min"] == (min(finite) if finite else None)
    assert result["max"] == (max(finite) if finite else None)
    assume(finite)
    assert result["rms"] is None or result["rms"] <= max(map(abs, finite)) * (1 + 1e-9)


def test_end_of_a_line_is_not_a_sample() -> None:
    times = numpy.array([0.0, 1.0, 1.0, 9.0, 10.0])
    result = measure(times, numpy.array([1.0, 2.0, math.nan, 3.0, math.nan]))
    assert result["rate"] == pytest.approx(0.3) and result["nan"] == 0.25


def test_fraction_of_nan_is_measured() -> None:
    values = numpy.array([1.0, math.nan, 2.0, math.inf])
    assert measure(numpy.arange(4.0), values)["nan"] == 0.5
    assert measure(numpy.arange(2.0), values[:1].repeat(2))["nan"] == 0.0
