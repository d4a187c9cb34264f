"""Tests of which measurements ci/bench makes."""

from goals import GOALS
from measurements import MEASUREMENTS, chosen

EXTREMES = {"fleet", "thousand", "throughput"}


def names(measurements):
    return {one.name for one in measurements}


def test_what_few_need_is_measured_only_on_request():
    everything = names(MEASUREMENTS)
    assert EXTREMES < everything
    assert names(chosen()) == everything - EXTREMES
    assert names(chosen(with_extremes=True)) == everything
    assert names(chosen(only=["thousand", "live"])) == {"thousand", "live"}


def test_each_goal_is_of_a_measurement():
    assert {goal.measurement for goal in GOALS} <= names(MEASUREMENTS)
    assert len(names(MEASUREMENTS)) == len(MEASUREMENTS)


def test_a_goal_is_as_extreme_as_its_words():
    for goal in GOALS:
        is_extreme = goal.what.startswith(("100 robots", "1000 groups", "rate without loss"))
        assert is_extreme is (goal.measurement in EXTREMES), goal.what
