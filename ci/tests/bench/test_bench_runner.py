"""Tests of the order and number of turns of ci/bench, with fake measurements."""

import contextlib
import subprocess
import time

import pytest

from ci.benchmark import machine
from ci.benchmark.context import Bench
from ci.benchmark.measurements import Measurement
from ci.benchmark.results import Results
from ci.benchmark.runner import Runner


@pytest.fixture(autouse=True)
def undisturbed(monkeypatch):
    monkeypatch.setattr(machine.Steal, "share", lambda _self: 0.0)


class Stage:
    """Subjects, and a log of their actions."""

    def __init__(self, turn=lambda subject: None):
        self.log = []
        self._turn = turn

    @contextlib.contextmanager
    def prepare(self, _bench, subject):
        self.log.append(f"{subject} up")

        def turn():
            self.log.append(subject)
            self._turn(subject)
            return {"p50_us": 1.0}

        yield turn
        self.log.append(f"{subject} down")

    def order(self):
        return [one for one in self.log if " " not in one]


def run(measurement, most=None, deadline=float("inf")):
    results = Results()
    bench = Bench(None, left_out={"absent": "it is not here"})
    Runner(bench, results, most, lambda _text: None).run([measurement], deadline)
    return results


def test_each_round_begins_with_another_subject_and_starts_are_shared():
    stage = Stage()
    results = run(Measurement("row", ["a", "absent", "b", "c"], stage.prepare, 3, 2))
    up, down = ["a up", "b up", "c up"], ["c down", "b down", "a down"]
    assert stage.log == [*up, *"abcbca", *down, *up, *"cab", *down]
    assert results.estimate("row", "a", "p50_us").turns == 3


def test_rounds_are_limited_by_number_and_by_time():
    for limits, expected in (({"most": 1}, 1), ({"deadline": time.monotonic() - 1.0}, 1), ({}, 6)):
        stage = Stage()
        run(Measurement("row", ["a"], stage.prepare, 6, 3), **limits)
        assert len(stage.order()) == expected


@pytest.mark.parametrize("error", [ValueError("no"), subprocess.CalledProcessError(1, "peer")])
def test_a_failure_is_reported_and_ends_no_other_subject(error):
    def turn(subject):
        if subject == "b":
            raise error

    stage = Stage(turn)
    results = run(Measurement("row", ["a", "b"], stage.prepare, 2, 2))
    assert results.failures == [f"row, b: {error!r}"]
    assert stage.order() == ["a", "b", "a"]


def test_turn_disturbed_by_the_host_is_repeated(monkeypatch):
    shares = iter([0.5, 0.02, 0.03, 0.5])
    monkeypatch.setattr(machine.Steal, "share", lambda _self: next(shares))
    results = run(Measurement("row", ["a"], Stage().prepare, 2, 2))
    assert results.disturbed["row"] == 3
    assert results.estimate("row", "a", "p50_us").turns == 1
