"""Tests of the causes that the judge names: laws with known faults, and correct laws."""

import math
import re
from typing import Any, Callable, Dict, List

import pytest
from hypothesis import given, settings

from pid_control.controller.pid import PID, PidSettings
from pid_control.identification.response import Model
from pid_control.judging.controller_judgement import judge
from pid_control.judging.evidence import ControllerEvidence, adapted, evidence_of
from pid_control.judging.experiment import MotorOutput
from pid_control.judging.probes import best_fit
from pid_control.judging.record import ENDED, Record
from pid_control.judging.scenarios import BY_NAME, scaled
from pid_control.verdicts.judgement import Judgement
from pid_control.verdicts.reports import as_sentences
from pid_control.judging.simulation import Law, pid_law, simulate
from pid_control.tuning.rules import METHODS, gains_of
from laws import CORRECT, clipped, correct, law_of
from played import default_limits, pi, play_all, play_one

LIMITS = default_limits()
#: Period of a student's loop [s].
LOOP_S = 0.01
#: Flaws that say only how well the motor follows.
ABOUT_GAINS = {"gains", "chatter", "unexplained"}


def student(kp: float = 0.08, ki: float = 1.5, **faults: Any) -> Callable[[], Law]:
    """Return a PI law with faults: sign, dt, leak, limit, least, unit, rounding, winds_up."""

    def step(state: Dict[str, float], set_point: float, speed: float, dt: float) -> float:
        error = faults.get("sign", lambda error: error)(set_point - speed)
        dt = faults.get("dt", dt)
        grown = state["integral"] * (1.0 - faults.get("leak", 0.0) * dt) + error * dt
        wanted = kp * error + ki * grown
        limit = faults.get("limit", 1.0)
        value = max(faults.get("least", -limit), min(limit, wanted))
        if value == wanted or faults.get("winds_up") or abs(grown) < abs(state["integral"]):
            state["integral"] = grown
        rounding = faults.get("rounding", 0.0)
        return (round(value / rounding) * rounding if rounding else value) * faults.get("unit", 1.0)

    return law_of(step)


def judged(make: Callable[[], Law], period: float = LOOP_S) -> Judgement:
    return judge(play_all(make, period), LIMITS)


def switch(state: Dict[str, float], set_point: float, speed: float, dt: float) -> float:
    """Return full voltage of either sign, with hysteresis."""
    error = set_point - speed
    if abs(error) > 0.5:
        state["input"] = math.copysign(1.0, error)
    return state["input"]


def delayed(state: Dict[str, float], set_point: float, speed: float, dt: float) -> float:
    """Return the answer of a PI law, four turns late."""
    error = set_point - speed
    state["integral"] = clipped(state["integral"] + error * dt, 0.7)
    names = ["input", "one", "two", "three"]
    for new, old in zip(names, names[1:]):
        state[new] = state.get(old, 0.0)
    state["three"] = clipped(0.08 * error + 1.5 * state["integral"])
    return state["input"]


def winds_up_above(state: Dict[str, float], set_point: float, speed: float, dt: float) -> float:
    """Return the answer of a PI law whose integral is limited below only."""
    error = set_point - speed
    state["integral"] = max(state["integral"] + error * dt, -0.7)
    return clipped(0.08 * error + 1.5 * state["integral"])


def without(topic: str) -> Callable[[], Law]:
    """Return a PI law that loses the value of a topic."""

    def make() -> Law:
        law = pi()()

        def answer(set_point: float, output: MotorOutput) -> float:
            if topic == "set_point":
                return law(0.0, output)
            return law(set_point, output._replace(speed=0.0))

        return answer

    return make


@pytest.mark.parametrize(
    "make, flaws, says",
    [
        (student(winds_up=True), "windup", ["windup: time to leave", "integral keeps growing"]),
        (student(limit=0.9, winds_up=True), "windup", ["integral keeps growing"]),
        (law_of(winds_up_above), "windup", ["integral keeps growing"]),
        (student(limit=1.1), "no clamp", ["to ±1.1, not to ±1", "divide it by 1.1)"]),
        (student(least=-1e9), "no clamp, windup", ["the input is not limited below: keep it"]),
        (
            student(least=-1e9, winds_up=True),
            "no clamp, windup",
            ["not limited below", "keeps growing"],
        ),
        (student(dt=0.001, ki=15.0), "interval", ["dt is a constant, not measured"]),
        (student(ki=0.0, kp=0.1), "no integral", ["P alone leaves a steady error"]),
        (
            student(unit=255.0),
            "units",
            ["a correct controller in other units", "divide it by 255"],
        ),
        (student(unit=12.0), "units", ["a correct controller in other units", "divide it by 12"]),
        (student(unit=12.0, winds_up=True), "units, windup", ["divide it by 12", "keeps growing"]),
        (
            student(sign=lambda error: -error),
            "sign",
            ["the sign is wrong: the error is the set point"],
        ),
        (student(sign=abs), "sign", ["the sign is wrong for an error below 0 only"]),
        (
            student(sign=lambda error: -abs(error)),
            "sign",
            ["the sign is wrong for an error above 0 only"],
        ),
        (without("set_point"), "deaf", ["does not depend on set_point"]),
        (without("motor_output"), "stale", ["does not depend on motor_output"]),
        (
            student(kp=0.0, ki=0.0),
            "no answer",
            ["the input never changes", "one of: its gains are 0"],
        ),
    ],
)
def test_judge_a_fault_is_named_as_a_fact_and_no_other(
    make: Callable[[], Law], flaws: str, says: List[str]
) -> None:
    judgement = judged(make)
    text = as_sentences(judgement)
    assert [words for words in says if words not in text] == [], text
    assert ", ".join(judgement.flaws()) == flaws, text


@pytest.mark.extended
@pytest.mark.parametrize(
    "make",
    [
        student(ki=27.0),
        student(kp=0.7, ki=73.0),
        student(leak=30.0),
        student(rounding=0.1),
        law_of(delayed),
    ],
)
def test_judge_names_no_false_cause(make: Callable[[], Law]) -> None:
    judgement = judged(make)
    assert set(judgement.flaws()) <= ABOUT_GAINS, as_sentences(judgement)


@pytest.mark.parametrize("make", [student(leak=3.0), law_of(switch), student(rounding=0.5)])
def test_judge_reports_an_unknown_cause(make: Callable[[], Law]) -> None:
    judgement = judged(make)
    assert judgement.flaws() == ["unexplained"], as_sentences(judgement)
    sentences = [failure.cause.sentence for failure in judgement.failures]
    assert all("one of: " in sentence for sentence in sentences)
    for gains in re.findall(r"kp (\S+) and ki (\S+)/s", " ".join(sentences)):
        assert float(gains[0]) < float(gains[1])  # as those of all three


def test_judge_constant_interval_of_a_loop_that_catches_up_is_a_fact() -> None:
    records = play_all(student(dt=0.001, ki=15.0), LOOP_S)
    # rospy.Rate makes two iterations at the same time in a slow loop: each grows as much.
    [index] = [i for i, record in enumerate(records) if record.scenario.name == "rate"]
    begin, end = records[index].scenario.slow
    answers, grown, before = [], 0.0, 0.0
    for time, value in records[index].answers:
        change, before = value - before, value
        is_slow = begin <= time < end
        answers.append((time, value + grown))
        if is_slow and abs(change) < 0.01:
            grown += change
            answers.append((time, value + grown))
    records[index] = records[index]._replace(answers=answers)
    text = as_sentences(judge(records, LIMITS))
    assert "dt is a constant, not measured" in text


def test_judge_gains_are_blamed_only_if_a_faultless_law_with_them_fails_too() -> None:
    judgement = judged(student(kp=0.005, ki=0.2))
    assert judgement.flaws() == ["gains"]
    assert "kp 0.005 and ki 0.2/s are unsuitable: tune them" in as_sentences(judgement)


def test_judge_several_faults_are_all_named_worst_first() -> None:
    judgement = judged(student(limit=1e9, winds_up=True, dt=0.001, ki=15.0))
    assert judgement.flaws() == ["no clamp", "windup", "interval"]


@pytest.mark.extended
@pytest.mark.parametrize("method", METHODS)
def test_judge_passes_the_gains_of_tune(method: str) -> None:
    gains = gains_of(Model(13.1, 0.04, 0.0), LOOP_S)[method]
    settings_ = PidSettings(
        mode=gains.mode, kp=gains.kp, ki=gains.ki, kd=gains.kd, filter_time=gains.filter_time
    )
    judgement = judged(lambda: pid_law(settings_), 0.0)
    assert set(judgement.flaws()) <= ABOUT_GAINS, as_sentences(judgement)


@pytest.mark.extended
@settings(max_examples=settings.default.max_examples // 4)
@given(**CORRECT)
def test_judge_correct_controllers_get_no_false_cause(period: float, **law: Any) -> None:
    judgement = judged(correct(**law), period)
    assert set(judgement.flaws()) <= ABOUT_GAINS, as_sentences(judgement)


def test_evidence_is_of_complete_records_only() -> None:
    held = Record(BY_NAME["held"], ENDED)
    assert evidence_of([held]) == ControllerEvidence()


def test_evidence_of_a_law_that_is_no_pi_has_no_gains() -> None:
    uneven = student(sign=lambda error: error if error > 0.0 else 2.0 * error)
    held = play_one("held", uneven)
    assert evidence_of([held]).law is None
    for is_output in (False, True):
        fit = best_fit(held.answers, is_output)
        assert fit is not None
        assert (fit.growth, fit.growth_below) == pytest.approx((1.5, 3.0), rel=0.01)
        above, below = fit.response()
        assert below - above == pytest.approx(0.1 * 1.5, rel=0.01)
    derivative = PidSettings(PID, 0.08, 1.5, 0.001)
    found = evidence_of([play_one("held", lambda: pid_law(derivative))])
    assert found.has_derivative and found.law is None
    assert evidence_of([play_one("windup", pi(output_min=-3.0, output_max=1.5))]).own_limit is None


def test_answers_that_are_late_by_several_turns_are_those_of_their_law() -> None:
    law, kept = pi()(), [0.0] * 5

    def answer(set_point: float, output: MotorOutput) -> float:
        kept.append(law(set_point, output))
        return kept.pop(0)

    answers = simulate(BY_NAME["held"], answer, LOOP_S).answers
    for is_output in (False, True):
        fit = best_fit(answers, is_output)
        assert fit is not None and fit.delay == pytest.approx(0.05, abs=0.001)
        assert (fit.gain, fit.growth) == pytest.approx((0.08, 1.5), rel=0.01)


@pytest.mark.parametrize("topic", ["set_point", "motor_output"])
def test_rate_is_adapted_to_a_controller_that_answers_one_topic(topic: str) -> None:
    held = play_one("held", without(topic))
    wanted = scaled(BY_NAME["rate"], 0.08, 1.5)
    largest = [max(one.set_point) for one in (wanted, adapted(BY_NAME["rate"], [held]))]
    assert largest[0] == pytest.approx(largest[1])


@pytest.mark.parametrize("least, largest", [(-0.5, 1.0), (-1.0, 0.75), (-1.5, 0.75), (-0.5, 1.5)])
def test_evidence_has_the_limit_of_each_side(least: float, largest: float) -> None:
    make = pi(output_min=least, output_max=largest)
    law = evidence_of([play_one("held", make), play_one("windup", make)]).law
    assert law is not None
    assert (law.least, law.largest) == pytest.approx((max(least, -1.0), min(largest, 1.0)))
