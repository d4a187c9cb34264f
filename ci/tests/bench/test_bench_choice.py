"""Tests of which measurements ci/bench makes."""

import pathlib
import subprocess

from ci.benchmark import machine
from ci.benchmark.goals import GOALS
from ci.benchmark.measurements import MEASUREMENTS, chosen

#: What nobody needs who does not ask for it.
EXTREMES = {"fleet", "thousand", "throughput"}


def names(measurements):
    return {one.name for one in measurements}


def test_what_few_need_is_measured_only_on_request():
    everything, main = names(MEASUREMENTS), names(chosen())
    assert EXTREMES < everything and not EXTREMES & main
    assert {"latency-1khz", "latency-100hz", "host-1khz", "robots", "launch", "memory"} < main
    assert not any(name.startswith("bridge") for name in main)
    assert names(chosen(with_extra=True)) == everything
    assert names(chosen(only=["thousand", "live"])) == {"thousand", "live"}


def test_help_lists_each_measurement():
    bench = pathlib.Path(machine.__file__).parents[1] / "bench"
    text = subprocess.check_output([str(bench), "--help"], universal_newlines=True)
    lines = [f"  {one.name:14} {one.help}" + one.is_extra * ", with --all" for one in MEASUREMENTS]
    assert text.splitlines()[-len(lines) :] == lines


def test_each_goal_is_of_a_measurement_and_of_its_subjects():
    subjects = {one.name: one.subjects for one in MEASUREMENTS}
    assert len(subjects) == len(MEASUREMENTS)
    for goal in GOALS:
        assert set(goal.subjects) <= set(subjects[goal.measurement]), goal.what


def test_a_goal_is_as_extreme_as_its_words():
    for goal in GOALS:
        is_extreme = goal.what.startswith(("100 robots", "1000 groups", "rate without loss"))
        assert is_extreme is (goal.measurement in EXTREMES), goal.what
