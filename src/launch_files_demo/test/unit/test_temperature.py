"""Temperature sensor: its measurements and their errors."""

import random
import statistics

import pytest
from hypothesis import given
from hypothesis import strategies as st

from launch_files_demo.temperature import (
    COLDEST,
    PERIOD_S,
    VARIANCE,
    WARMEST,
    measured,
    true_temperature,
)


@given(st.floats(0.0, 1e9), st.integers(0, 2**32))
def test_measurement_is_in_range_and_near_true_value(time: float, seed: int) -> None:
    value = measured(time, random.Random(seed))
    assert COLDEST <= value <= WARMEST
    assert abs(value - true_temperature(time)) < 7.0 * VARIANCE**0.5


@pytest.mark.parametrize("time, expected", [(0.0, 15.0), (15.0, 35.0), (45.0, -5.0), (60.0, 15.0)])
def test_it_rises_and_falls_once_in_a_minute(time: float, expected: float) -> None:
    assert true_temperature(time) == pytest.approx(expected)
    assert true_temperature(time + PERIOD_S) == pytest.approx(expected)


def test_noise_has_published_variance() -> None:
    chance = random.Random(1)
    errors = [measured(0.0, chance) - true_temperature(0.0) for _ in range(20000)]
    assert statistics.fmean(errors) == pytest.approx(0.0, abs=0.02)
    assert statistics.pvariance(errors) == pytest.approx(VARIANCE, rel=0.05)
