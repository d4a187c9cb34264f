"""Tests of how ci/bench judges its results."""

import pytest

from ci.benchmark.goals import GOALS, Outcome
from ci.benchmark.measurements import MEASUREMENTS
from ci.benchmark.report import tables
from ci.benchmark.results import Results


def judged(results, what):
    (goal,) = [goal for goal in GOALS if goal.what == what]
    return goal.judge(results)


def hops(results, *repeats, **p50s):
    for repeat in repeats:
        for subject, p50 in p50s.items():
            results.add("latency-1khz", subject, repeat, {"p50_us": p50})


def test_what_was_not_measured_is_not_judged():
    assert all(goal.judge(Results()) is None for goal in GOALS)


@pytest.mark.parametrize("ours, passed", [(75.0, True), (76.0, False)])
def test_a_ratio_is_judged_against_its_limit(ours, passed):
    results = Results()
    hops(results, 0, 1, 2, basic_comms=ours, roscpp=100.0)
    assert judged(results, "p50 at 1 kHz, against roscpp").outcome is (
        Outcome.PASS if passed else Outcome.SHORT
    )


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
    for repeat in range(2):  # it is not made more often
        results.add("throughput", "basic_comms", repeat, {"rate": rate})
    assert judged(results, "rate without loss").outcome is (
        Outcome.PASS if passed else Outcome.SHORT
    )


def test_a_goal_of_what_is_measured_once_is_decided_by_one_turn():
    slow = {one.name: one.slow for one in MEASUREMENTS}
    goals = [goal for goal in GOALS if set(goal.subjects) <= set(slow[goal.measurement])]
    assert {goal.measurement for goal in goals} == {"thousand"}
    results = Results()
    results.add("thousand", "basic_comms", 0, {"holding": 1000.0, "cpu_percent": 61.0})
    assert [goal.judge(results).outcome for goal in goals] == [Outcome.PASS, Outcome.SHORT]


def test_times_faster_has_the_slower_one_on_top():
    results = Results()
    for repeat in range(3):
        results.add("latency-10hz", "basic_comms", repeat, {"p50_us": 200.0})
        results.add("latency-10hz", "course", repeat, {"p50_us": 50000.0})
    verdict = judged(results, "faster at 10 Hz, against course")
    assert verdict.value == 250.0 and verdict.outcome is Outcome.PASS


def test_drift_counts_in_either_direction_and_by_the_worst_repeat():
    results = Results()
    for repeat, drift in enumerate([0.01, -0.2, 0.02]):
        results.add("drift", "basic_comms", repeat, {"drift_ms": drift})
    verdict = judged(results, "drift in 20 s at 1 kHz")
    assert verdict.value == 0.2 and verdict.outcome is Outcome.SHORT


HOP = "p50 at 1 kHz, against roscpp"  # 0.75 x at most


@pytest.mark.parametrize(
    "ratios, outcome",
    [
        ([0.70, 0.71, 0.72, 0.70, 0.74], Outcome.PASS),
        ([0.76, 0.80, 0.79, 0.81, 0.78], Outcome.SHORT),
        ([0.60, 0.90, 0.62, 0.88, 0.70], Outcome.UNCLEAR),
    ],
)
def test_a_goal_is_reached_only_if_the_whole_interval_is(ratios, outcome):
    results = Results()
    for repeat, ratio in enumerate(ratios):
        hops(results, repeat, basic_comms=100.0 * ratio, roscpp=100.0)
    verdict = judged(results, HOP)
    assert verdict.outcome is outcome
    assert verdict.interval.low <= verdict.value <= verdict.interval.high
    assert verdict.turns == 5 and verdict.is_settled is (outcome is not Outcome.UNCLEAR)


def test_an_interval_of_few_turns_says_how_sure_it_is():
    results = Results()
    for repeat, p50 in enumerate([40.0, 50.0, 60.0]):
        hops(results, repeat, basic_comms=p50, roscpp=100.0)
    assert "| 0.4 to 0.6 (75 %) | 3 " in tables(results, ["latency-1khz"], {}, {})
    for repeat in range(3, 6):
        hops(results, repeat, basic_comms=50.0, roscpp=100.0)
    assert "(" not in tables(results, ["latency-1khz"], {}, {})


def test_too_few_turns_decide_nothing_and_beside_disturbed_ones_are_no_figure():
    results = Results()
    hops(results, 0, 1, basic_comms=50.0, roscpp=100.0)
    assert judged(results, HOP).outcome is Outcome.UNCLEAR
    results.disturbed["latency-1khz"] = 4
    assert judged(results, HOP).outcome is Outcome.NOT_MEASURABLE
    text = tables(results, ["latency-1khz"], {}, {})
    assert "latency-1khz: 4 turns are left out" in text
    hops(results, 2, basic_comms=50.0, roscpp=100.0)
    assert judged(results, HOP).outcome is Outcome.PASS


@pytest.mark.parametrize("missing", [None, ("rospy", 0), ("rclpy", 1), ("to_ros2", 2)])
@pytest.mark.parametrize(
    "measurement, figure, what",
    [
        ("bridge", "p50_us", "p50 to ROS 2, against a hop of each"),
        ("bridge-actions", "feedback_p50_us", "p50 of feedback from ROS 2, against both ROSes"),
    ],
)
def test_what_goes_through_the_bridge_is_compared_with_both_hops_of_its_turn(
    measurement, figure, what, missing
):
    results = Results()
    for repeat, (rospy, rclpy) in enumerate([(100.0, 200.0), (600.0, 100.0), (20.0, 40.0)]):
        for subject, p50 in (("rospy", rospy), ("rclpy", rclpy), ("to_ros2", (rospy + rclpy) / 2)):
            if (subject, repeat) != missing:
                results.add(measurement, subject, repeat, {figure: p50})
    verdict = judged(results, what)
    assert verdict.value == pytest.approx(0.5) and verdict.turns == 3 - bool(missing)
    assert verdict.interval == pytest.approx((0.5, 0.5))
