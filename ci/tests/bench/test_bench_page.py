"""Tests of the table of docs/benchmark.md."""

import json
import pathlib

from ci.benchmark import page
from ci.benchmark.goals import GOALS
from ci.benchmark.measurements import MEASUREMENTS

RESULTS = pathlib.Path(page.__file__).parents[2] / "docs" / "results"


def test_table_of_the_docs_matches_their_figures():
    content = json.loads((RESULTS / "benchmark.json").read_text())
    text = page.make_table(page.read(content), content["machine"])
    assert text == (RESULTS / "benchmark.inc").read_text()


def test_lines_without_figures_are_left_out():
    content = json.loads((RESULTS / "benchmark.json").read_text())
    content["figures"] = [one for one in content["figures"] if one["row"] != "latency-100hz"]
    text = page.make_table(page.read(content), content["machine"])
    assert "100 Hz" not in text and "latency at 1 kHz" in text and "of a hop in each ROS" in text


def test_every_line_is_of_a_measurement_or_a_goal():
    subjects = {one.name: one.subjects for one in MEASUREMENTS}
    for _, row, _, columns in page.FIGURES:
        assert set(columns) <= set(subjects[row])
    goals = {(goal.measurement, goal.what) for goal in GOALS}
    assert {(row, goal) for _, row, goal in page.RATIOS} <= goals
