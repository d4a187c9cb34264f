"""Tests of the causes that the judge names: laws with known faults, and correct laws."""

import math
from typing import Any, Callable, Dict, List

import pytest
from hypothesis import given, settings

from pid_control.controller.pid import PID, PidSettings
from pid_control.identification.response import Model
from pid_control.judging.controller_judgement import judge
from pid_control.judging.evidence import (
    ControllerEvidence,
    Law,
    adapted,
    evidence_of,
    faultless_figures,
)
from pid_control.judging.experiment import MotorOutput
from pid_control.judging.probes import best_fit
from pid_control.judging.record import ENDED, Record
from pid_control.judging.scenarios import BY_NAME, scaled
from pid_control.verdicts.judgement import Judgement, causes
from pid_control.verdicts.reports import as_sentences
from pid_control.judging.simulation import Law as Answers
from pid_control.judging.simulation import pid_law, simulate
from pid_control.tuning.rules import METHODS, gains_of
from laws import CORRECT, clipped, correct, law_of
from played import default_limits, pi, play_all, play_one

LIMITS = default_limits()
#: Period of a student's loop [s].
LOOP_S = 0.01
#: Flaws that say only how well the motor follows.
ABOUT_GAINS = {"gains", "chatter", "unexplained"}


def student(kp: float = 0.08, ki: float = 1.5, **faults: Any) -> Callable[[], Answers]:
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


def judged(make: Callable[[], Answers], period: float = LOOP_S) -> Judgement:
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


def without(topic: str) -> Callable[[], Answers]:
    """Return a PI law that loses the value of a topic."""

    def make() -> Answers:
        law = pi()()

        def answer(set_point: float, output: MotorOutput) -> float:
            if topic == "set_point":
                return law(0.0, output)
            return law(set_point, output._replace(speed=0.0))

        return answer

    return make


WINDUP = "the integral keeps growing while the output is limited; stop it there"
UNITS = (
    "a correct controller in other units: its input is limited to ±{0}, the motor's to ±1; divide"
    " it by {0}"
)
NOT_BELOW = "the input goes below -1: limit it"
#: Evidence of a student's PI law without a fault.
FAULTLESS = ControllerEvidence(True, True, law=Law(0.08, 1.5, LOOP_S))
BOTH = ("above", "below")


@pytest.mark.parametrize(
    "make, named, evidence",
    [
        (student(winds_up=True), {("windup", WINDUP): 2}, {"winds_up": True}),
        (
            student(limit=0.9, winds_up=True),
            {("windup", WINDUP): 2},
            {"winds_up": True, "law": Law(0.08, 1.5, LOOP_S, -0.9, 0.9)},
        ),
        (law_of(winds_up_above), {("windup", WINDUP): 2}, {"winds_up": True}),
        (
            student(limit=1.1),
            {
                (
                    "no clamp",
                    "the input is limited to ±1.1, not to ±1: one of: a limit that is too wide, or"
                    " other units (divide it by 1.1)",
                ): 2
            },
            {"own_limit": 1.1, "beyond": BOTH},
        ),
        (
            student(least=-1e9),
            {("no clamp", NOT_BELOW): 1, ("windup", WINDUP): 2},
            {"winds_up": True, "beyond": ("below",)},
        ),
        (
            student(least=-1e9, winds_up=True),
            {("no clamp", NOT_BELOW): 1, ("windup", WINDUP): 2},
            {"winds_up": True, "beyond": ("below",)},
        ),
        (
            student(dt=0.001, ki=15.0),
            {
                (
                    "interval",
                    "the integral does not follow the elapsed time: dt is a constant, not measured",
                ): 1
            },
            {"grows_per_turn": True},
        ),
        (
            student(ki=0.0, kp=0.1),
            {("no integral", "P alone leaves a steady error: add I"): 18},
            {"lacks_integral": True, "law": Law(0.1, 0.0, LOOP_S, -0.8658, 0.8658)},
        ),
        (
            student(unit=255.0),
            {("units", UNITS.format(255)): 36},
            {
                "own_limit": 255.0,
                "is_in_other_units": True,
                "beyond": BOTH,
                "law": Law(20.4, 382.5, LOOP_S),
            },
        ),
        (
            student(unit=12.0, winds_up=True),
            {("units", UNITS.format(12)): 34, ("windup", WINDUP): 1},
            {
                "own_limit": 12.0,
                "is_in_other_units": True,
                "beyond": BOTH,
                "winds_up": True,
                "law": Law(0.96, 18.0, LOOP_S),
            },
        ),
        (
            student(sign=lambda error: -error),
            {("sign", "the sign is wrong: the error is the set point less the output"): 21},
            {"wrong_signs": ("set_point", "motor_output"), "law": None},
        ),
        (
            student(sign=abs),
            {("sign", "the sign is wrong for an error below 0 only"): 14},
            {"wrong_above": False, "law": None},
        ),
        (
            student(sign=lambda error: -abs(error)),
            {("sign", "the sign is wrong for an error above 0 only"): 22},
            {"wrong_above": True, "law": None},
        ),
        (
            without("set_point"),
            {
                (
                    "deaf",
                    "the input does not depend on set_point: its callback's value is not used",
                ): 19
            },
            {"ignores": ("set_point",), "law": None},
        ),
        (
            without("motor_output"),
            {
                (
                    "stale",
                    "the input does not depend on motor_output: its callback's value is lost",
                ): 24
            },
            {"ignores": ("motor_output",), "law": None},
        ),
        (
            student(kp=0.0, ki=0.0),
            {
                (
                    "no answer",
                    "the input never changes: one of: its gains are 0 (are its parameters loaded,"
                    " by its launch file?), or the values of its callbacks are lost",
                ): 20
            },
            {"ignores": ("set_point", "motor_output"), "law": None},
        ),
    ],
)
def test_judge_a_fault_is_named_as_a_fact_and_no_other(
    make: Callable[[], Answers], named: Dict[Any, int], evidence: Dict[str, Any]
) -> None:
    records = play_all(make, LOOP_S)
    judgement = judge(records, LIMITS)
    failures = causes(judgement)
    assert {tuple(cause): len(failures[cause]) for cause in failures} == named
    assert judgement.flaws() == [flaw for flaw, _ in named]  # the worst first
    expected, found = FAULTLESS._replace(**evidence), evidence_of(records)
    assert found._replace(law=None) == expected._replace(law=None)
    assert found.law == (expected.law and pytest.approx(expected.law, rel=1e-3, abs=1e-9))


def test_judge_constant_input_of_p_alone_is_no_limit() -> None:
    found = causes(judged(student(kp=0.2, ki=0.0, limit=math.inf)))
    assert {cause.flaw for cause in found} >= {"no clamp", "no integral"}
    assert ("no clamp", "the input leaves -1 to 1: limit it") in found


def test_judge_output_is_not_ignored_by_a_law_that_is_limited_while_the_set_point_is_0() -> None:
    def step(state: Dict[str, float], set_point: float, speed: float, dt: float) -> float:
        return max(0.03, min(1.0, 0.2 * (abs(set_point) - abs(speed))))

    records = play_all(law_of(step), LOOP_S)
    assert evidence_of(records).ignores == ()
    assert "stale" not in judge(records, LIMITS).flaws()


def constant_set_point(value: float) -> Callable[[], Answers]:
    """Return a PI law for a constant set point."""

    def make() -> Answers:
        law = pi()()
        return lambda set_point, output: law(value, output)

    return make


@pytest.mark.parametrize("value", [0.0, 5.0, -3.0])
def test_judge_constant_set_point_of_the_controller_is_deaf(value: float) -> None:
    judgement = judged(constant_set_point(value))
    assert judgement.flaws()[0] == "deaf"
    assert not {"windup", "windup or delay", "unexplained"} & set(judgement.flaws())


def waiting(seconds: float) -> Callable[[], Answers]:
    """Return a correct law that sends 0 for some time."""

    def make() -> Answers:
        law, began = pi()(), None

        def answer(set_point: float, output: MotorOutput) -> float:
            nonlocal began
            began = output.time if began is None else began
            return 0.0 if output.time - began < seconds else law(set_point, output)

        return answer

    return make


@pytest.mark.parametrize("seconds", [2.0, 5.0, 6.0])
def test_judge_late_start_is_not_taken_for_a_lost_set_point(seconds: float) -> None:
    judgement = judged(waiting(seconds))
    (cause,) = causes(judgement)
    assert cause.flaw == "late start"
    assert (
        f"is constant for the first {seconds:.0f} s or so of a run: one of: the" in cause.sentence
    )


@pytest.mark.parametrize("names", [["held"], ["held", "steps"]])
def test_judge_late_start_is_not_known_from_a_motor_that_is_held(names: List[str]) -> None:
    records = [play_one(name, waiting(5.0)) for name in names]
    evidence = evidence_of(records)
    assert (evidence.starts_at, evidence.ignores) == (None, ())
    assert not {"deaf", "late start"} & set(judge(records, LIMITS).flaws())


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
def test_judge_names_no_false_cause(make: Callable[[], Answers]) -> None:
    judgement = judged(make)
    assert set(judgement.flaws()) <= ABOUT_GAINS, as_sentences(judgement)


NO_PI = (
    ": unknown cause, because its answers to small errors are not those of P or PI: one of: it"
    " switches, is rounded, delayed or limited, or its integral leaks"
)


@pytest.mark.parametrize(
    "make, sentences",
    [
        (
            student(leak=3.0),
            {
                "it is slow, or oscillates for long, which its kp 0.0994 and ki 1.29/s do not"
                " explain: one of: the integral leaks, is reset or limited too low, or the law"
                " differs for large errors": 15
            },
        ),
        (
            law_of(switch),
            {
                f"it oscillates{NO_PI}": 2,
                f"it is slow, or oscillates for long{NO_PI}": 15,
                f"the input is larger than necessary{NO_PI}": 1,
                f"the input chatters{NO_PI}": 3,
            },
        ),
        (
            student(rounding=0.5),
            {
                f"it is slow, or oscillates for long{NO_PI}": 11,
                f"the input chatters{NO_PI}": 2,
            },
        ),
    ],
)
def test_judge_reports_an_unknown_cause(
    make: Callable[[], Answers], sentences: Dict[str, int]
) -> None:
    judgement = judged(make)
    assert judgement.flaws() == ["unexplained"], as_sentences(judgement)
    failures = causes(judgement)
    assert {cause.sentence: len(failures[cause]) for cause in failures} == sentences


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
    probed = FAULTLESS._replace(law=None)
    assert evidence_of([held]) == probed
    for is_output in (False, True):
        fit = best_fit(held.answers, is_output)
        assert fit == pytest.approx((0.001, 0.12, 1.5, 0.12, 3.0, 0.0, 0.0, 1.0), abs=1e-6)
        assert fit.response() == pytest.approx((0.27, 0.42))
    derivative = PidSettings(PID, 0.08, 1.5, 0.001)
    held = play_one("held", lambda: pid_law(derivative))
    assert evidence_of([held]) == probed._replace(has_derivative=True)
    for is_output, leap in ((False, 0.0), (True, 0.4955)):  # of the output only
        fit = best_fit(held.answers, is_output)
        assert fit == pytest.approx((0.001, 0.08, 1.5, 0.08, 1.5, 0.0, leap, 1.0), abs=1e-6)

    def inverse_below(state: Dict[str, float], set_point: float, speed: float, dt: float) -> float:
        return 0.08 * (speed - set_point if set_point < 0.0 else set_point - speed)

    # One topic of two: neither the sign of all errors below 0, nor that of the topic.
    found = evidence_of([play_one("held", law_of(inverse_below))])
    assert (found.wrong_above, found.wrong_signs, found.law) == (None, (), None)
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


def test_law_is_that_of_two_errors_in_proportion() -> None:
    """A single error of another size may fit by chance."""

    def answer(set_point: float, output: MotorOutput) -> float:
        error = set_point - output.speed
        return error * (0.16 if abs(error) < 0.005 else 0.08)

    answers = simulate(BY_NAME["held"], answer, LOOP_S).answers
    for is_output in (False, True):
        fit = best_fit(answers, is_output)
        assert fit == pytest.approx((0.01, 0.08, 0.0, 0.08, 0.0, 0.0, 0.0, 1.0), abs=1e-6)


def test_figures_of_a_faultless_law_are_those_of_its_limits_and_period() -> None:
    law = Law(0.08, 1.5, 0.03, -0.5, 0.5)
    assert evidence_of([play_one("held", pi())]).law[3:] == (-1.0, 1.0)
    figures = faultless_figures(law, "steps")
    assert (figures["peak_input"], figures["late"] > 0.9) == (0.5, True)


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
