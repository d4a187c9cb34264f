"""Samples of two traces, paired by time."""

import math
from typing import List

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.analysis.xy import LONGEST, paired, thinned

TIMES = numpy.arange(0.0, 10.0, 0.01)


def test_fields_of_one_message_are_paired_exactly() -> None:
    random = numpy.random.RandomState(1)
    x, y = random.standard_normal((2, len(TIMES)))
    assert (paired((TIMES, x), (TIMES, y), 0.05) == [x, y]).all()


@settings(max_examples=30)
@given(st.floats(0.001, 0.009), st.floats(0.5, 2.0))
def test_other_times_are_interpolated(late: float, radius: float) -> None:
    moments = TIMES[:-1] + late
    points = paired((TIMES, radius * numpy.cos(TIMES)), (moments, radius * numpy.sin(moments)), 0.1)
    assert numpy.hypot(*points) == pytest.approx(radius, rel=1e-4)


def test_unknown_values_are_nan() -> None:
    x = numpy.array([0.0, 1.0, 5.0, 6.0]), numpy.array([0.0, 1.0, 5.0, math.nan])
    y = numpy.array([-1.0, 0.5, 1.0, 3.0, 5.0, 5.5, 7.0]), numpy.arange(7.0)
    right, up = paired(x, y, 2.0)
    assert right.tolist()[1:3] == [0.5, 1.0] and right[4] == 5.0
    assert numpy.isnan(right[[0, 3, 5, 6]]).all() and (numpy.isnan(up) == numpy.isnan(right)).all()
    assert paired((TIMES[:0], TIMES[:0]), y, 1.0).shape == (2, 7)


@settings(max_examples=30)
@given(st.lists(st.tuples(st.floats(), st.floats()), max_size=50))
def test_thinned_points_are_some_of_them(pairs: List[tuple]) -> None:
    numbers = numpy.array(pairs, float).reshape(-1, 2).T
    points = paired(
        (numpy.arange(float(len(pairs))), numbers[0]),
        (numpy.arange(float(len(pairs))), numbers[1]),
        2.0,
    )
    kept = thinned(points)
    finite = {tuple(point) for point in points.T if numpy.isfinite(point).all()}
    assert all(tuple(point) in finite for point in kept.T if numpy.isfinite(point).all())
    assert finite == set() or kept.shape[1] > 0


@pytest.mark.parametrize("count", [5000, 30000, 100001])
def test_no_peak_of_a_single_sample_is_lost(count: int) -> None:
    angles = numpy.linspace(0.0, 40.0 * math.pi, count)
    points = numpy.array([numpy.cos(angles), numpy.sin(angles)])
    tall = numpy.linspace(100, count - 100, 10).astype(int)
    points[1, tall[::2]], points[0, tall[1::2]] = 5.0, -5.0
    points[:, count // 3] = numpy.nan
    kept = thinned(points)
    assert kept.shape[1] <= LONGEST and numpy.isnan(kept[0]).any()
    assert (kept[1] == 5.0).sum() == 5 and (kept[0] == -5.0).sum() == 5
    given = {tuple(point) for point in points.T.tolist() if point[0] == point[0]}
    assert all(tuple(point) in given for point in kept.T.tolist() if point[0] == point[0])


def test_a_long_path_keeps_its_form() -> None:
    turns = numpy.linspace(0.0, 200.0, 100000)
    kept = thinned(numpy.array([turns * numpy.cos(turns), turns * numpy.sin(turns)]))
    assert kept.shape[1] <= LONGEST
    still = thinned(numpy.ones((2, 1000)))
    assert still.shape[1] == 2
