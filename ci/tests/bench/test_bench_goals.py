"""Tests of the results and goals of ci/bench."""

import pytest

from ci.benchmark.goals import GOALS, Outcome
from ci.benchmark.report import as_json, tables
from ci.benchmark.results import Results

HOP = ("latency-1khz", "p50, against roscpp")  # 0.75 x at most


def check(results, row, what):
    (goal,) = [goal for goal in GOALS if (goal.measurement, goal.what) == (row, what)]
    value = goal.estimate(results)
    return value, goal.outcome(value)


def hops(results, *rounds, **p50s):
    for number in rounds:
        for subject, p50 in p50s.items():
            results.add("latency-1khz", subject, number, {"p50_us": p50})


def test_goal_without_results_has_no_value():
    assert all(goal.estimate(Results()) is None for goal in GOALS)


def test_ratio_compares_turns_of_the_same_round():
    results = Results()
    hops(results, 0, basic_comms=50.0, roscpp=100.0)
    hops(results, 1, basic_comms=500.0, roscpp=1000.0)
    hops(results, 2, basic_comms=60.0)  # its peer failed
    value, _ = check(results, *HOP)
    assert (value.median, value.turns) == (0.5, 2)


@pytest.mark.parametrize(
    "ratios, outcome",
    [
        ([0.70, 0.71, 0.72, 0.70, 0.75], Outcome.PASS),
        ([0.76, 0.80, 0.79, 0.81, 0.78], Outcome.SHORT),
        ([0.60, 0.90, 0.62, 0.88, 0.70], Outcome.UNCLEAR),
    ],
)
def test_goal_is_decided_only_by_the_whole_interval(ratios, outcome):
    results = Results()
    for number, ratio in enumerate(ratios):
        hops(results, number, basic_comms=100.0 * ratio, roscpp=100.0)
    value, found = check(results, *HOP)
    assert found is outcome and value.turns == 5


@pytest.mark.parametrize("missing", [None, ("rospy", 0), ("rclpy", 1), ("to_ros2", 2)])
def test_bridge_is_compared_with_both_hops_of_its_round(missing):
    results = Results()
    for number, (rospy, rclpy) in enumerate([(100.0, 200.0), (600.0, 100.0), (20.0, 40.0)]):
        for subject, p50 in (("rospy", rospy), ("rclpy", rclpy), ("to_ros2", (rospy + rclpy) / 2)):
            if (subject, number) != missing:
                results.add("bridge", subject, number, {"p50_us": p50})
    value, _ = check(results, "bridge", "p50 to ROS 2, against a hop of each")
    assert value == pytest.approx((0.5, 0.5, 0.5, 3 - bool(missing)))


def test_tables_show_confidence_losses_and_failures():
    results = Results()
    for number, p50 in enumerate([40.0, 50.0, 60.0]):
        hops(results, number, basic_comms=p50, roscpp=100.0)
    results.disturbed["latency-1khz"] = 4
    results.failures.append("latency-1khz, rospy: no")
    text = tables(results, ["latency-1khz"], {"cores": "2"}, {"rclpy": "not here"})
    assert "| 0.4 to 0.6 (75 %) | 3 " in text
    assert "latency-1khz: 4 turns are left out" in text
    assert "rclpy is left out: not here." in text and "FAILED: latency-1khz, rospy: no" in text
    for number in range(3, 6):
        hops(results, number, basic_comms=50.0, roscpp=100.0)
    assert " %)" not in tables(results, ["latency-1khz"], {}, {})


def test_json_holds_goals_figures_and_turns():
    results = Results()
    hops(results, 0, basic_comms=50.0, roscpp=100.0)
    content = as_json(results, {"cores": "2"}, {})
    assert [goal["median"] for goal in content["goals"]] == [0.5]
    assert [one["median"] for one in content["figures"]] == [50.0, 100.0]
    assert [one["figures"] for one in content["turns"]] == [{"p50_us": 50.0}, {"p50_us": 100.0}]
