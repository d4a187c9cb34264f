"""Radar targets: consistency of the values of each."""

import math

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from parameters_demo.traffic import SIGHT, VIEW, returns, targets

TIMES = st.floats(0.0, 1e6)


@given(TIMES)
def test_one_to_ten_returns_within_range(time: float) -> None:
    seen = returns(time)
    assert seen.shape[1] == 5 and 1 <= len(seen) <= 10
    ranges, azimuths, elevations, dopplers, amplitudes = seen.T
    assert (ranges > 0.0).all() and (ranges <= SIGHT).all()
    assert (abs(azimuths) <= VIEW).all() and (abs(elevations) < 0.3).all()
    assert (abs(dopplers) <= 25.0).all()
    assert (amplitudes > 0.0).all() and (amplitudes < 100.0).all()


def test_targets_appear_and_disappear() -> None:
    assert len({len(returns(time)) for time in range(100)}) > 2


@given(TIMES)
def test_the_doppler_velocity_is_how_fast_the_range_grows(time: float) -> None:
    step = 1e-3
    before, now, after = (targets(time + late)[0] for late in (-step, 0.0, step))
    velocity = targets(time)[1]
    stays = abs(after[:, 0] - before[:, 0]) < 1.0  # but those that have just come into sight
    moved = (after - before) / (2.0 * step)
    assert moved[stays] == pytest.approx(velocity[stays], abs=1e-3)
    ranges = numpy.linalg.norm(now, axis=1)
    growth = numpy.linalg.norm(after, axis=1) - numpy.linalg.norm(before, axis=1)
    expected = (growth / (2.0 * step))[stays & _seen(now, ranges)]
    dopplers = returns(time)[:, 3]
    for one in expected:
        assert abs(dopplers - one).min() < 0.01


@given(TIMES)
def test_range_and_angles_lead_back_to_the_place(time: float) -> None:
    places = targets(time)[0]
    places = places[_seen(places, numpy.linalg.norm(places, axis=1))]
    ranges, azimuths, elevations = returns(time).T[:3]
    flat = ranges * numpy.cos(elevations)
    back = [flat * numpy.cos(azimuths), flat * numpy.sin(azimuths), ranges * numpy.sin(elevations)]
    assert numpy.stack(back, axis=1) == pytest.approx(places, abs=1e-9)


def test_double_range_is_12_db_weaker() -> None:
    strengths = {}
    for time in numpy.arange(0.0, 20.0, 0.1):
        ranges = returns(float(time))[0]  # the walker, who comes first
        strengths[round(40.0 * math.log10(ranges[0]) + ranges[4], 9)] = time
    assert list(strengths) == [60.0 - 5.0 + 40.0]


def _seen(places: numpy.ndarray, ranges: numpy.ndarray) -> numpy.ndarray:
    azimuths = numpy.arctan2(places[:, 1], places[:, 0])
    return (abs(azimuths) <= VIEW) & (ranges <= SIGHT)
