"""Tests of the rows of ci/bench: names, and selection."""

import importlib
import pathlib
import subprocess

import pytest

from ci.benchmark import names
from ci.benchmark.goals import GOALS
from ci.benchmark.measurements import MEASUREMENTS, select
from ci.endurance.names import COMMANDS

CI = pathlib.Path(names.__file__).parents[1]


def test_every_measurement_has_a_name_and_is_selected_by_it():
    assert [one.name for one in MEASUREMENTS] == [*names.MAIN, *names.EXTRA]
    assert [one.name for one in select()] == list(names.MAIN)
    assert select(is_all=True) == MEASUREMENTS
    assert [one.name for one in select(only=["memory", "overlap"])] == ["memory", "overlap"]


@pytest.mark.parametrize("name", [name for runs in COMMANDS.values() for name in runs])
def test_every_long_run_has_a_module(name):
    assert callable(importlib.import_module(f"ci.endurance.run_{name}").run)


@pytest.mark.parametrize(
    "command, rows",
    [
        ("bench", {**names.MAIN, **names.EXTRA}),
        ("soak", COMMANDS["soak"]),
        ("two-hosts", COMMANDS["two-hosts"]),
    ],
)
def test_help_without_ros_lists_all_names_on_one_screen(command, rows):
    done = subprocess.run(
        [str(CI / command), "--help"],
        env={"PATH": "/usr/bin:/bin"},
        stdout=subprocess.PIPE,
        universal_newlines=True,
        check=True,
    )
    lines = done.stdout.splitlines()
    assert len(lines) < 40
    assert [line.split()[0] for line in lines[-len(rows) :]] == list(rows)


def test_every_goal_is_of_a_measurement_and_its_subjects():
    subjects = {one.name: one.subjects for one in MEASUREMENTS}
    for goal in GOALS:
        assert {goal.subject, *goal.peers} <= set(subjects[goal.measurement]), goal.what
