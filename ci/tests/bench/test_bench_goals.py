"""Tests of how ci/bench judges its results."""

import pytest
from goals import GOALS
from results import Results


def judged(results, what):
    (goal,) = [goal for goal in GOALS if goal.what == what]
    return goal.judge(results)


def hops(results, repeat, **p50s):
    for subject, p50 in p50s.items():
        results.add("latency-1khz", subject, repeat, {"p50_us": p50})


def test_what_was_not_measured_is_not_judged():
    assert all(goal.judge(Results()) is None for goal in GOALS)


@pytest.mark.parametrize("ours, passed", [(75.0, True), (76.0, False)])
def test_a_ratio_is_judged_against_its_limit(ours, passed):
    results = Results()
    hops(results, 0, basic_comms=ours, roscpp=100.0)
    assert judged(results, "p50 at 1 kHz, against roscpp").passed is passed


def test_a_ratio_compares_runs_of_the_same_repeat():
    results = Results()
    hops(results, 0, basic_comms=50.0, roscpp=100.0)
    hops(results, 1, basic_comms=500.0, roscpp=1000.0)
    hops(results, 2, basic_comms=60.0)  # its peer failed
    assert judged(results, "p50 at 1 kHz, against roscpp").value == 0.5


def test_a_peer_measured_once_is_compared_by_medians():
    results = Results()
    results.add("latency-1khz", "basic_comms", 1, {"p50_us": 50.0})
    results.add("latency-1khz", "roscpp", 0, {"p50_us": 100.0})
    assert judged(results, "p50 at 1 kHz, against roscpp").value == 0.5


@pytest.mark.parametrize("rate, passed", [(50000.0, True), (49000.0, False)])
def test_a_least_figure_is_judged_from_below(rate, passed):
    results = Results()
    results.add("throughput", "basic_comms", 0, {"rate": rate})
    assert judged(results, "rate without loss").passed is passed


def test_times_faster_has_the_slower_one_on_top():
    results = Results()
    results.add("latency-10hz", "basic_comms", 0, {"p50_us": 200.0})
    results.add("latency-10hz", "course", 0, {"p50_us": 50000.0})
    verdict = judged(results, "faster at 10 Hz, against course")
    assert verdict.value == 250.0 and verdict.passed


def test_drift_counts_in_either_direction_and_by_the_worst_repeat():
    results = Results()
    for repeat, drift in enumerate([0.01, -0.2, 0.02]):
        results.add("drift", "basic_comms", repeat, {"drift_ms": drift})
    verdict = judged(results, "drift in 20 s at 1 kHz")
    assert verdict.value == 0.2 and not verdict.passed
