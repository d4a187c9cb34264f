"""Tests of autocorrelated noise: against sums by hand, and against the whole covariance."""

from typing import List

import numpy
import pytest

from pid_control.identification.noise import covariance_of_sums, outputs_per_independent_one


@pytest.mark.parametrize(
    "errors, count",
    [
        # r1 to r24 of 100 are 0.99 to 0.76: a quarter of the residuals is used.
        ([2.0] * 100, 1.0 + 2.0 * 21.0),
        # r1 is 1 of 100, and r2 is negative.
        ([1.0, 1.0, -1.0, -1.0] * 25, 1.02),
        ([1.0, -1.0] * 50, 1.0),
        ([0.0] * 100, 1.0),
        ([2.0] * 7, 1.0),
        ([2.0] * 8, 1.0 + 2.0 * 7.0 / 8.0),
    ],
)
def test_residuals_per_independent_one_are_the_autocorrelations_sum(
    errors: List[float], count: float
) -> None:
    assert outputs_per_independent_one(numpy.array(errors)) == pytest.approx(count)


@pytest.mark.parametrize("per_independent, alike", [(1.0, 0.0), (3.0, 0.5), (19.0, 0.9)])
def test_covariance_of_sums_is_that_of_autocorrelated_noise(
    per_independent: float, alike: float
) -> None:
    columns = numpy.random.RandomState(1).normal(0.0, 1.0, (30, 3))
    places = numpy.arange(30)
    whole = alike ** numpy.abs(places[:, None] - places)
    expected = columns.T @ whole @ columns
    assert covariance_of_sums(columns, per_independent) == pytest.approx(expected)
