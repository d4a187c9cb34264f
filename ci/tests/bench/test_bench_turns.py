"""Tests of how ci/bench takes turns: with measurements made up here, of which nothing is run."""

import collections
import contextlib
import itertools
import pathlib
import subprocess

import pytest

from ci.benchmark import machine, turns
from ci.benchmark.context import Bench
from ci.benchmark.measurements import Measurement
from ci.benchmark.peer_programs import Peers
from ci.benchmark.results import Results

#: A row with a goal of its own: p50 of basic_comms is to be 0.75 x that of roscpp, or less.
ROW = "latency-1khz"


@pytest.fixture(name="bench")
def make_bench():
    return Bench(None, Peers(pathlib.Path(), None, None, {"absent": "it is not here"}), False)


class Stage:
    """Subjects that stand ready, and a diary of what they did.

    :param figures: what each turn of a subject comes to: a function of its number
    """

    def __init__(self, figures):
        self.diary = []
        self._figures = figures
        self._numbers = collections.defaultdict(itertools.count)

    def measurement(self, subjects, name=ROW):
        return Measurement(name, "", subjects, stand_ready=self._stand_ready)

    @contextlib.contextmanager
    def _stand_ready(self, _bench, subject):
        self.diary.append(f"{subject} up")

        def turn():
            self.diary.append(subject)
            return {"p50_us": self._figures(subject, next(self._numbers[subject]))}

        yield turn
        self.diary.append(f"{subject} down")

    def order(self):
        return [one for one in self.diary if " " not in one]


def take(bench, measurement, most=None):
    results = Results()
    turns.Turns([measurement], bench, results, most, lambda _text: None).take_all()
    return results


def test_the_order_of_turns_changes_and_all_are_started_anew_after_two_rounds(bench):
    stage = Stage(lambda subject, _number: 1.0)
    take(bench, stage.measurement(["a", "absent", "b", "c"]), most=3)
    up, down = ["a up", "b up", "c up"], ["c down", "b down", "a down"]
    assert stage.diary == [*up, *"abcbca", *down, *up, *"cab", *down]


def test_who_has_no_goal_has_a_few_turns(bench):
    stage = Stage(lambda subject, number: 100.0 + 50.0 * (number % 2))
    results = take(bench, stage.measurement(["a", "b"], "latency-50hz"))
    assert results.turns("latency-50hz", "a") == results.turns("latency-50hz", "b") == 6


def test_turns_go_on_until_the_goal_is_decided_and_others_leave_earlier(bench):
    # The first turns are on either side of the goal.
    ours = [70.0, 80.0, 70.0, 80.0, 70.0, 80.0] + 30 * [70.0]
    stage = Stage(lambda subject, number: ours[number] if subject == "basic_comms" else 100.0)
    results = take(bench, stage.measurement(["basic_comms", "rospy", "roscpp"]))
    assert results.turns(ROW, "rospy") == 6
    assert 6 < results.turns(ROW, "basic_comms") == results.turns(ROW, "roscpp") < 36


def test_turns_end_though_nothing_is_decided(bench, monkeypatch):
    def figures(subject, number):
        if number == 19:
            monkeypatch.setattr(turns, "ROW_S", 0.0)  # now there is no time left
        return 100.0 if subject == "roscpp" else 50.0 + 50.0 * (number % 2)

    results = take(bench, Stage(figures).measurement(["basic_comms", "roscpp"]))
    assert results.turns(ROW, "basic_comms") == 20


@pytest.mark.parametrize("error", [ValueError("no"), subprocess.CalledProcessError(1, "peer")])
def test_one_that_fails_is_told_of_and_keeps_no_other_from_its_turns(bench, error):
    def figures(subject, number):
        if subject == "b" and number == 1:
            raise error
        return 1.0

    stage = Stage(figures)
    results = take(bench, stage.measurement(["a", "b"], "latency-50hz"))
    assert results.failures == [f"latency-50hz, b: {error!r}"]
    assert results.turns("latency-50hz", "a") == 6
    assert stage.order().count("b") == 2


def test_turns_that_the_host_disturbed_are_left_out_and_taken_again(bench, monkeypatch):
    shares = iter([0.5, 0.0, 0.03] + 100 * [0.02])
    monkeypatch.setattr(machine.Steal, "share", lambda _self: next(shares))
    stage = Stage(lambda subject, number: float(number))
    results = take(bench, stage.measurement(["a"], "latency-50hz"))
    assert results.disturbed["latency-50hz"] == 2
    assert results.values("latency-50hz", "a", "p50_us") == [1.0, 3.0, 4.0, 5.0, 6.0, 7.0]
    stolen = [one["stolen"] for one in results.conditions]
    assert stolen == [0.5, 0.0, 0.03] + 5 * [0.02]


def test_what_starts_afresh_is_measured_once_in_each_repeat(bench):
    order = []

    def measure(_bench, subject):
        order.append(subject)
        return {"p50_us": 1.0}

    once = Measurement("live", "", ["x"], measure, repeats=1)
    often = Measurement("rest", "", ["y", "z"], measure)
    results = Results()
    turns.Turns([once, often], bench, results, 2, lambda _text: None).take_all()
    assert order == ["x", "y", "z", "z", "y"]


def test_what_is_measured_once_counts_for_no_repeat_of_the_others(bench, monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(turns.time, "monotonic", lambda: clock[0])

    def lasting(seconds):
        def measure(_bench, _subject):
            clock[0] += seconds
            return {"p50_us": 1.0}

        return measure

    once = Measurement("live", "", ["x"], lasting(100.0), repeats=1)
    often = Measurement("rest", "", ["y"], lasting(10.0))
    results = Results()
    turns.Turns([often, once], bench, results, None, lambda _text: None).take_all(150.0)
    assert results.turns("live", "x") == 1 and results.turns("rest", "y") == 5


def test_what_is_slow_is_measured_until_there_is_one_turn(bench, monkeypatch):
    shares = iter([0.0, 0.5, 0.0, 0.0, 0.0])
    monkeypatch.setattr(machine.Steal, "share", lambda _self: next(shares))
    order = []

    def measure(_bench, subject):
        order.append(subject)
        return {"p50_us": 1.0}

    row = Measurement("latency-50hz", "", ["a", "slow"], measure, repeats=2, slow=["slow"])
    results = Results()
    turns.Turns([row], bench, results, None, lambda _text: None).take_all()
    assert order == ["a", "slow", "slow", "a", "a"]
    assert results.turns("latency-50hz", "slow") == 1
