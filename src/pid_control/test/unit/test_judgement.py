"""Tests of limits, diagnosis and reports."""

import functools
import math
from typing import Dict, List, Optional
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as some

from pid_control.charts.chart import Curve, Panel
from pid_control.judging.controller_judgement import is_fatal, judge
from pid_control.verdicts.batch_page import as_html, as_page_of_student
from pid_control.judging.diagnosis import FLAWS, cause_of, cause_of_failure
from pid_control.verdicts.judgement import (
    FAILED,
    NOT_JUDGED,
    PASSED,
    Cause,
    Failure,
    Finding,
    Judgement,
    found,
    number,
)
from pid_control.verdicts.limits import LimitsError, merged, read_limits
from pid_control.judging.evidence import ControllerEvidence, Law, faultless_figures
from pid_control.judging.metrics import METRICS, SCENARIO_METRICS
from pid_control.judging import picture
from pid_control.judging.picture import as_svg
from pid_control.judging.record import (
    ENDED,
    NOT_CONNECTED,
    RESTLESS,
    SILENT,
    WRITES_WITHOUT_END,
    Pause,
    Record,
    Row,
)
from pid_control.verdicts.reports import as_csv, as_junit, as_sentences, as_table, text_cell
from pid_control.judging.scenarios import BY_NAME
from laws import clipped, law_of
from played import default_limits, pi, play_all, play_one

LIMITS = default_limits()
SVG = "{http://www.w3.org/2000/svg}"


def test_default_limits_cover_every_metric() -> None:
    for scenario, names in SCENARIO_METRICS.items():
        assert set(LIMITS[scenario]) == set(names)
        assert all(limit is not None for limit in LIMITS[scenario].values())


def test_merged_replaces_named_limits_only() -> None:
    own = read_limits(
        "steps: {overshoot: 5, rise_time: null}\nwindup:\n  leave_time: 0.1\n", SCENARIO_METRICS
    )
    both = merged(LIMITS, own)
    assert (both["steps"]["overshoot"], both["steps"]["rise_time"]) == (5.0, None)
    assert both["windup"] == {**LIMITS["windup"], "leave_time": 0.1}
    assert both["nan"] == LIMITS["nan"] and LIMITS["steps"]["overshoot"] == 25.0
    assert read_limits("", SCENARIO_METRICS) == {} and merged(LIMITS, {}) == LIMITS
    assert read_limits("steps: {overshoot: 0}", SCENARIO_METRICS) == {"steps": {"overshoot": 0.0}}


NO_LIMIT = "must be a number of at least 0, or null"
NO_YAML = "it is not YAML: "


@pytest.mark.parametrize(
    "text, says",
    [
        ("steps: {late: -1}", f"steps: late: -1 {NO_LIMIT}"),
        ("steps: {late: lots}", f"steps: late: 'lots' {NO_LIMIT}"),
        ("steps: {late: true}", f"steps: late: True {NO_LIMIT}"),
        ("steps: {late: .nan}", f"steps: late: nan {NO_LIMIT}"),
        ("steps: {late: .inf}", f"steps: late: inf {NO_LIMIT}"),
        (f"steps: {{late: {10**400}}}", f"steps: late: 1{'0' * 59} {NO_LIMIT}"),
        ("steps: {late: [1]}", f"steps: late: [1] {NO_LIMIT}"),
        ("steps: {late: false}", f"steps: late: False {NO_LIMIT}"),
        ("steps: {latte: 1}", "steps: latte: not measured there, but rise_time, late"),
        ("step: {late: 1}", "step: unknown scenario; choose from steps, ramp"),
        ("steps: 5", "steps: must hold limits by name, not 5"),
        (f"steps: {'x' * 99}", f"steps: must hold limits by name, not '{'x' * 59}"),
        ("[steps]", "it must hold scenarios, each with its limits, not ['steps']"),
        ("x" * 99, f"it must hold scenarios, each with its limits, not '{'x' * 59}"),
        ("steps: {late: 1", NO_YAML),
        ("steps: {late: 1}\nsteps: {late: 1}", "line 2: duplicate key steps"),
        ("steps:\n  late: 1\n  late: 2\n", "line 3: duplicate key late"),
        ("7: {late: 1}", "line 1: 7 is not a name"),
        ("\n[7, [8]]: {late: 1}", "line 2: [7, [8]] is not a name"),
        ("steps: !!python/object/apply:os.getcwd []", NO_YAML),
        ("a: &a [*a]", NO_YAML),
        ("steps: {late: 2001-99-99}", NO_YAML),
    ],
)
def test_read_limits_invalid_text_names_the_problem(text: str, says: str) -> None:
    with pytest.raises(LimitsError) as error:
        read_limits(text, {"steps": ["rise_time", "late"], "ramp": []})
    assert str(error.value) == says or (says == NO_YAML and str(error.value).startswith(says))


@given(some.text(max_size=40))
def test_read_limits_any_text_raises_only_limits_error(text: str) -> None:
    try:
        read_limits(text, SCENARIO_METRICS)
    except LimitsError as error:
        assert str(error)


#: Figures of the reference controller, in the order of the table.
FIGURES = {
    "held": "0.23 0.23 0 0 1 0 0",
    "rate": "0 0",
    "steps": "0.12 0 0.176 0 1.12 0.783 0.714 0 0 0",
    "ramp": "0.274 0.68",
    "sine": "0.613 0.603",
    "windup": "0.002 0.204 1",
    "noise": "0.00618 0.0115 0.41",
    "load": "0.18 0 0.582",
    "slower": "2.08 0.164 0 0.795",
    "faster": "0 0.182 0 0 0.567",
    "missing": "0.112 1",
    "restart": "0.166 0.762",
    "early": "0.182 0.4",
    "nan": "0 0 0.415",
}


def test_a_good_controller_passes() -> None:
    judgement = judge(play_all(pi()), LIMITS)
    figures: Dict[str, List[str]] = {}
    for finding in judgement.findings:
        figures.setdefault(finding.scenario, []).append(number(finding.value))
    assert {scenario: " ".join(texts) for scenario, texts in figures.items()} == FIGURES
    assert judgement.failures == []
    assert (judgement.verdict, judgement.status, judgement.flaws()) == (PASSED, 0, [])
    assert as_sentences(judgement) == "passed: all 50 figures of 14 scenarios"


def test_judge_windup_reports_cause_and_figure() -> None:
    judgement, _ = bad_judgement()
    assert (judgement.verdict, judgement.status) == (FAILED, 1)
    assert judgement.flaws() == ["windup"]
    text = as_sentences(judgement)
    assert "windup: time to leave the limit 1." in text
    assert "the integral keeps growing while the output is limited; stop it there" in text
    assert text.endswith("failed: windup")


def poor(state: Dict[str, float], set_point: float, speed: float, dt: float) -> float:
    """Return the answer of a PI law with a constant dt, windup and a limit of 1.5."""
    error = set_point - speed
    state["integral"] += 0.02 * error
    return clipped(0.05 * error + 2.5 * state["integral"], 1.5)


POOR = """\
scenario  what                                  figure           limit
held      answer to the set point               0.217 1/(rad/s)  >= 0.001
          answer to the motor                   0.217 1/(rad/s)  >= 0.001
          jump of the input at a step           0 1/(rad/s)      <= 0.1
          answers while the clock is paused     0                <= 1
          idle share while the clock is paused  1                >= 0.5
          share of time without answer          0.996            <= 0.05   FAILED
          processor time for each second        0 s              <= 1
rate      integrated time during pauses         0 s              <= 0.05
          integral off at another rate          0.571            <= 0.25   FAILED
steps     rise time                             0.062 s          <= 0.5
          overshoot                             0 %              <= 25
          settling time                         0.11 s           <= 0.8
          steady error                          0 rad/s          <= 0.1
          integral of |error|                   0.799 rad        <= 5
          integral of input squared             0.8 s            <= 3
          largest |input|                       0.782            <= 1
          chatter of the input                  0                <= 0.05
          share of time without answer          0.993            <= 0.05   FAILED
          processor time for each second        0 s              <= 1
ramp      mean |error|                          0.22 rad/s       <= 1.5
          largest |input|                       0.68             <= 1
sine      mean |error|                          0.529 rad/s      <= 2
          largest |input|                       0.613            <= 1
windup    time to leave the limit               1.1 s            <= 0.3    FAILED
          time to recover                       1.32 s           <= 1      FAILED
          largest |input|                       1.5              <= 1      FAILED
noise     steady error                          0.0352 rad/s     <= 0.1
          chatter of the input                  0.0238           <= 0.1
          largest |input|                       0.481            <= 1
load      time to recover                       0.14 s           <= 0.9
          steady error                          0 rad/s          <= 0.1
          largest |input|                       0.582            <= 1
slower    overshoot                             8.16 %           <= 40
          settling time                         0.296 s          <= 0.9
          steady error                          0 rad/s          <= 0.1
          largest |input|                       0.845            <= 1
faster    overshoot                             22.1 %           <= 40
          settling time                         0.2 s            <= 0.9
          steady error                          0 rad/s          <= 0.1
          chatter of the input                  0                <= 0.1
          largest |input|                       0.618            <= 1
missing   time to recover                       0.054 s          <= 0.7
          largest |input|                       0.682            <= 1
restart   time to recover                       0.162 s          <= 0.8
          largest |input|                       0.857            <= 1
early     time to recover                       0.09 s           <= 1
          largest |input|                       0.5              <= 1
nan       time to recover                       0 s              <= 0.5
          answers that are not finite           0                <= 0
          largest |input|                       0.5              <= 1

held: share of time without answer 0.996, at most 0.05
steps: share of time without answer 0.993, at most 0.05
windup: time to recover 1.32 s, at most 1 s
  likely cause (too seldom): it answers too seldom: its loop is far slower than 100 Hz

windup: largest |input| 1.5, at most 1
  likely cause (no clamp): the input is limited to ±1.5, not to ±1: one of: a limit that is too \
wide, or other units (divide it by 1.5)

windup: time to leave the limit 1.1 s, at most 0.3 s
  likely cause (windup): the integral keeps growing while the output is limited; stop it there

rate: integral off at another rate 0.571, at most 0.25
  likely cause (interval): the integral does not follow the elapsed time: dt is a constant, not \
measured

failed: too seldom, no clamp, windup, interval"""


def test_judge_report_of_a_poor_controller() -> None:
    judgement = judge(play_all(law_of(poor), 0.03), LIMITS)
    assert as_table(judgement) + "\n\n" + as_sentences(judgement) == POOR


def test_judge_p_controller_reports_no_integral() -> None:
    judgement = judge(play_all(pi(kp=0.1, ki=0.0)), LIMITS)
    assert judgement.flaws() == ["no integral"]


SLOW = "it is slow, or oscillates for long"
SYMPTOMS = {
    "overshoot": "it oscillates",
    "chatter": "the input chatters",
    "effort": "the input is larger than necessary",
}
UNKNOWN = "{}: one of: unsuitable kp and ki, or a fault that the scenario held would show"
#: Sentence of each flaw without further evidence; with the symptom.
SENTENCES = {
    "derivative kick": "the derivative is of the error, which jumps at a step of the set point: use"
    " the derivative of the output",
    "restless": "it computes without a pause: a loop without rospy.Rate",
    "flood": "it sends without a pause: a loop without rospy.Rate",
    "machine clock": "it uses the machine's clock (time.time(), time.sleep()), not ROS's"
    " (rospy.get_time(), rospy.Rate): judge it with --real-time",
    "too seldom": "it answers too seldom: its loop is far slower than 100 Hz",
    "too slow": "one loop iteration takes longer than its period",
    "unexplained": "the input hardly depends on the error",
    "no clamp": "the input leaves -1 to 1: limit it",
    "windup or delay": "the input leaves its limit late: one of: the integral grows while the"
    " output is limited, or the answer is delayed",
    "interval": "the integral grows at another rate in a slow loop: one of: dt is a constant, or"
    " is limited",
    "nan": "NaN stays in its state: ignore such messages",
    "gains": UNKNOWN,
    "chatter": UNKNOWN,
}


@pytest.mark.parametrize(
    "figures, scenario, metric, flaw",
    [
        ({}, "held", "kick", "derivative kick"),
        ({("held", "standstill_rest"): 0.1}, "held", "processor", "restless"),
        (
            {("held", "standstill_rest"): 0.1, ("held", "standstill_answers"): 900.0},
            "held",
            "processor",
            "flood",
        ),
        ({("held", "standstill_answers"): 20.0}, "held", "late", "machine clock"),
        ({("held", "standstill_answers"): 20.0}, "held", "kick", "machine clock"),
        ({("held", "standstill_answers"): 1.0}, "held", "kick", "derivative kick"),
        ({("rate", "standstill_jump"): 0.3}, "rate", "standstill_jump", "machine clock"),
        ({("rate", "standstill_jump"): 0.3}, "held", "late", "machine clock"),
        ({("rate", "standstill_jump"): 0.3}, "held", "kick", "derivative kick"),
        ({("held", "late"): 1.0}, "steps", "late", "too seldom"),
        ({("held", "late"): 0.06}, "steps", "overshoot", "too seldom"),
        ({("held", "late"): 0.05}, "steps", "overshoot", "gains"),
        ({("rate", "standstill_jump"): 0.05}, "held", "standstill_answers", "gains"),
        ({("rate", "standstill_jump"): 0.06}, "held", "standstill_answers", "machine clock"),
        ({("held", "standstill_rest"): 0.5}, "held", "processor", "too slow"),
        (
            {("held", "standstill_rest"): 0.1, ("held", "standstill_answers"): 200.0},
            "held",
            "late",
            "restless",
        ),
        (
            {("held", "standstill_rest"): 0.1, ("held", "standstill_answers"): 201.0},
            "held",
            "late",
            "flood",
        ),
        ({("held", "late"): 1.0}, "steps", "settling_time", "too seldom"),
        ({("steps", "late"): 1.0}, "steps", "settling_time", "too seldom"),
        (
            {("held", "late"): 1.0, ("windup", "leave_time"): 1.0},
            "windup",
            "leave_time",
            "windup or delay",
        ),
        ({}, "held", "processor", "too slow"),
        ({}, "held", "set_point_response", "unexplained"),
        ({}, "steps", "peak_input", "no clamp"),
        ({("windup", "leave_time"): 1.0}, "windup", "recovery_time", "windup or delay"),
        ({("windup", "leave_time"): 1.0}, "load", "recovery_time", "gains"),
        ({("windup", "leave_time"): 0.1}, "windup", "recovery_time", "gains"),
        ({}, "rate", "interval_error", "interval"),
        ({("nan", "not_finite"): 5.0}, "nan", "recovery_time", "nan"),
        ({("nan", "recovery_time"): math.inf}, "nan", "recovery_time", "nan"),
        ({("nan", "recovery_time"): 0.7}, "nan", "recovery_time", "gains"),
        (
            {("nan", "recovery_time"): math.inf, ("missing", "recovery_time"): math.inf},
            "nan",
            "recovery_time",
            "gains",
        ),
        (
            {("nan", "recovery_time"): math.inf, ("steps", "settling_time"): math.inf},
            "nan",
            "recovery_time",
            "gains",
        ),
        ({}, "steps", "chatter", "chatter"),
        ({}, "steps", "overshoot", "gains"),
        ({}, "steps", "effort", "gains"),
    ],
)
def test_cause_of_returns_the_cause_that_the_figures_show(
    figures: Dict[tuple, Optional[float]], scenario: str, metric: str, flaw: str
) -> None:
    cause = cause_of(scenario, metric, figures)
    sentence = SENTENCES[flaw].format(SYMPTOMS.get(metric, SLOW))
    assert cause == (flaw, sentence)


LAW = Law(0.08, 1.5, 0.01)
MEASURED = ControllerEvidence(was_measured=True)
PROBED = MEASURED._replace(was_probed=True)
WINDUP = ("windup", "the integral keeps growing while the output is limited; stop it there")


@pytest.mark.parametrize(
    "evidence, scenario, metric, flaw, sentence",
    [
        (
            MEASURED,
            "steps",
            "peak_input",
            "no clamp",
            "the input is within -1 and 1, but beyond the limit for it",
        ),
        (
            MEASURED._replace(beyond=("above", "below")),
            "steps",
            "peak_input",
            "no clamp",
            "the input leaves -1 to 1: limit it",
        ),
        (
            MEASURED._replace(beyond=("above",)),
            "steps",
            "peak_input",
            "no clamp",
            "the input goes above 1: limit it",
        ),
        (
            MEASURED._replace(beyond=("below",), own_limit=2.5),
            "steps",
            "peak_input",
            "no clamp",
            "the input is limited to ±2.5, not to ±1: one of: a limit that is too wide, or other"
            " units (divide it by 2.5)",
        ),
        *(
            (
                PROBED._replace(own_limit=255.0, is_in_other_units=True, winds_up=True),
                "steps",
                metric,
                "units",
                "a correct controller in other units: its input is limited to ±255, the motor's to"
                " ±1; divide it by 255",
            )
            for metric in ("peak_input", "kick", "rise_time", "tracking_error", "effort")
        ),
        (
            PROBED._replace(own_limit=255.0, is_in_other_units=True, winds_up=True),
            "windup",
            "leave_time",
            *WINDUP,
        ),
        (
            PROBED._replace(is_in_other_units=True, own_limit=255.0, grows_per_turn=True),
            "rate",
            "interval_error",
            "interval",
            "the integral does not follow the elapsed time: dt is a constant, not measured",
        ),
        (PROBED._replace(winds_up=True), "windup", "recovery_time", *WINDUP),
        *(
            (
                PROBED._replace(wrong_signs=(topic,)),
                "held",
                metric,
                "sign",
                f"the sign of {topic} is wrong: the error is set point less output",
            )
            for topic in ("set_point", "motor_output")
            for metric in ("set_point_response", "output_response", "settling_time", "leave_time")
        ),
        (
            PROBED._replace(wrong_signs=("set_point",)),
            "held",
            "kick",
            "derivative kick",
            "the derivative is of the error, which jumps at a step of the set point: use the"
            " derivative of the output",
        ),
        (
            PROBED._replace(has_derivative=True),
            "steps",
            "chatter",
            "chatter",
            "the input chatters: one of: unsuitable kp, ki or kd, or a derivative without a filter",
        ),
        *(
            (
                PROBED._replace(lacks_integral=True),
                "steps",
                metric,
                "no integral",
                "P alone leaves a steady error: add I",
            )
            for metric in ("rise_time", "settling_time", "steady_error", "absolute_error")
        ),
        (
            PROBED._replace(lacks_integral=True),
            "steps",
            "chatter",
            "unexplained",
            "the input chatters: unknown cause, because its answers to small errors are not those"
            " of P or PI: one of: it switches, is rounded, delayed or limited, or its integral"
            " leaks",
        ),
        (
            PROBED._replace(grows_per_turn=True, law=LAW),
            "steps",
            "settling_time",
            "interval",
            "the integral is too slow, by the error of its constant dt",
        ),
        (
            PROBED._replace(grows_per_turn=True, law=LAW),
            "steps",
            "overshoot",
            "gains",
            "it oscillates: kp 0.08 and ki 1.5/s are unsuitable: tune them",
        ),
    ],
)
def test_cause_of_evidence_decides_between_rivals(
    evidence: ControllerEvidence, scenario: str, metric: str, flaw: str, sentence: str
) -> None:
    figures: Dict[tuple, Optional[float]] = {("windup", "leave_time"): 0.101}
    if metric == "leave_time":
        figures["steps", "late"] = 1.0  # a loop that is too slow does not explain that
    assert cause_of(scenario, metric, figures, evidence) == (flaw, sentence)


def test_cause_of_figure_that_a_faultless_law_keeps_is_not_its_gains() -> None:
    asked = []

    def is_broken(scenario: str, metric: str, figure: Optional[float]) -> bool:
        asked.append((scenario, metric, figure))
        return False

    winding = PROBED._replace(winds_up=True, law=LAW)
    for scenario in ("missing", "early", "windup", "load"):
        cause = cause_of(scenario, "recovery_time", {}, winding, is_broken)
        figure = faultless_figures(LAW, scenario)["recovery_time"]
        assert asked.pop() == (scenario, "recovery_time", figure) and figure
        assert cause == (
            WINDUP
            if scenario != "load"
            else (
                "unexplained",
                "it is slow, or oscillates for long, which its kp 0.08 and ki 1.5/s do not explain:"
                " one of: the integral leaks, is reset or limited too low, or the law differs for"
                " large errors",
            )
        )


def test_cause_of_every_metric_is_known() -> None:
    for scenario, names in SCENARIO_METRICS.items():
        assert names, scenario
        for name in names:
            beyond = -1.0 if METRICS[name].is_least else 1e9
            assert cause_of(scenario, name, {(scenario, name): beyond}).flaw in FLAWS


STEPS = BY_NAME["steps"]


@pytest.mark.parametrize(
    "record, flaw, sentence",
    [
        (
            Record(STEPS, ENDED, "KeyError: 9"),
            "crash",
            "the controller ended by itself: KeyError: 9",
        ),
        (Record(STEPS, ENDED), "crash", "the controller ended by itself"),
        (
            Record(STEPS, WRITES_WITHOUT_END),
            "endless output",
            "the controller writes to its log without end",
        ),
        (Record(STEPS, RESTLESS, answers=[(0.0, 0.0)] * 200), "restless", SENTENCES["restless"]),
        (Record(STEPS, RESTLESS, answers=[(0.0, 0.0)] * 201), "flood", SENTENCES["flood"]),
        (
            Record(STEPS, SILENT, "waiting"),
            "silent",
            "the controller sends nothing on motor_input: waiting",
        ),
        (
            Record(STEPS, SILENT, "waiting", answers=[(0.1, 0.0), (1.5, 0.0)]),
            "crash",
            "the controller sends nothing after 1.50 s: waiting",
        ),
        (
            Record(STEPS, NOT_CONNECTED, "hi", missing=["motor_input"], hint="it publishes /u"),
            "silent",
            "the controller does not publish motor_input; it publishes /u: hi",
        ),
        (
            Record(STEPS, NOT_CONNECTED, "hi", missing=["motor_output", "set_point"], hint="why"),
            "not connected",
            "the controller does not subscribe to motor_output and set_point; why: hi",
        ),
        (
            Record(STEPS, NOT_CONNECTED, missing=["set_point"]),
            "not connected",
            "the controller does not subscribe to set_point",
        ),
    ],
)
def test_cause_of_failure_names_the_reason(record: Record, flaw: str, sentence: str) -> None:
    cause = cause_of_failure(record)
    assert cause == (flaw, sentence)
    judgement = judge([record], LIMITS)
    failure = Failure("steps", record.failure, cause)
    assert judgement == Judgement(FAILED, [], [failure])
    assert is_fatal(record, LIMITS) == (flaw != "crash" or not record.answers)


def test_judge_machine_clock_is_not_judged() -> None:
    record = play_one("held", pi())._replace(pauses=[Pause(5.2, 0.5, 1.0, 25)])
    judgement = judge([record], LIMITS)
    assert (judgement.verdict, judgement.status) == (NOT_JUDGED, 125)
    assert judgement.reason == SENTENCES["machine clock"]
    assert is_fatal(record, LIMITS)
    # Whatever else it does.
    both = judge([record, Record(STEPS, ENDED, "KeyError: 9")], LIMITS)
    assert (both.verdict, both.reason) == (NOT_JUDGED, judgement.reason)


def test_judge_division_by_0_with_a_simulated_clock_is_not_judged() -> None:
    words = "ZeroDivisionError: float division by zero (controller.py, line 38)"
    record = Record(STEPS, ENDED, words, is_simulated=True)
    reason = (
        f"the controller ended by itself: {words}; one of: its own fault, or a dt of 0, as two"
        " iterations can have the same simulated time: judge it with --real-time"
    )
    failure = Failure("steps", ENDED, Cause("division by 0", reason))
    assert judge([record], LIMITS) == Judgement(NOT_JUDGED, [], [failure], reason)
    assert judge([record._replace(words="KeyError: 9")], LIMITS).flaws() == ["crash"]
    assert judge([record._replace(is_simulated=False)], LIMITS).flaws() == ["crash"]


def test_judge_never_idle_comes_before_an_iteration_that_is_too_long() -> None:
    slow = play_one("ramp", pi())._replace(scenario=STEPS, rows=play_one("steps", pi()).rows)
    assert judge([slow._replace(busy=9.0), Record(STEPS, RESTLESS)], LIMITS).flaws()[:2] == [
        "restless",
        "too slow",
    ]


def test_judge_time_limit_is_not_a_pass() -> None:
    good = judge([play_one("held", pi())], LIMITS, "60 s are over in rate")
    assert (good.verdict, good.reason) == (NOT_JUDGED, "60 s are over in rate")
    bad = judge([play_one("windup", pi(anti_windup="none"))], LIMITS, "60 s are over")
    assert bad.verdict == FAILED
    assert judge([], LIMITS).verdict == NOT_JUDGED


def test_sentences_list_scenarios_left_out() -> None:
    good = judge([play_one("ramp", pi())], LIMITS)._replace(left_out=["held", "rate"])
    lines = ["not judged with a real plant: held, rate", "passed: all 2 figures of 1 scenario"]
    assert as_sentences(good).splitlines() == lines


def test_is_fatal_ordinary_flaw_is_false() -> None:
    assert not is_fatal(play_one("windup", pi(anti_windup="none")), LIMITS)
    assert not is_fatal(play_one("held", pi(kp=-0.1, ki=-1.0)), LIMITS)
    assert not is_fatal(Record(STEPS, ENDED, answers=[(1.0, 0.5)]), LIMITS)
    assert is_fatal(Record(STEPS, ENDED), LIMITS)


def test_is_fatal_loop_longer_than_its_period_is_true() -> None:
    """All scenarios would take more than two minutes."""
    held = play_one("held", pi())
    for share, fatal in ((0.9, False), (1.1, True)):
        record = held._replace(busy=share * held.scenario.duration)
        assert is_fatal(record, LIMITS) is fatal
        assert judge([record], LIMITS).flaws() == ["too slow"] * fatal


def test_judge_no_limit_always_passes_and_float32_rounding_is_tolerated() -> None:
    record = play_one("windup", pi(anti_windup="none"))
    free = merged(LIMITS, {"windup": {"leave_time": None, "recovery_time": None}})
    assert judge([record], free).verdict == PASSED
    answers = [(time, 1.00000001) for time, _ in record.answers]
    assert judge([record._replace(answers=answers)], free).verdict == PASSED
    answers = [(time, 1.001) for time, _ in record.answers]
    assert judge([record._replace(answers=answers)], free).flaws() == ["no clamp"]
    least = {"held": {"kick": 0.5}}
    assert found("held", "kick", 0.49999999, least, "", is_least=True).passed
    assert not found("held", "kick", 0.499, least, "", is_least=True).passed


def test_number_formats_figures() -> None:
    assert [number(value, "s") for value in (None, math.inf, 1e-5, 0.12345)] == [
        "-",
        "never",
        "0 s",
        "0.123 s",
    ]
    assert number(math.inf, "rad") == "endless" and number(2.0) == "2"


@functools.lru_cache(maxsize=None)
def bad_judgement() -> tuple:
    """Return the judgement of a controller with windup, and its records; played once for all."""
    records = tuple(play_all(pi(anti_windup="none")))
    return judge(records, LIMITS), records


def test_the_table_fits_a_terminal_and_marks_failures() -> None:
    lines = as_table(bad_judgement()[0]).splitlines()
    assert max(map(len, lines)) <= 80
    assert [line.split()[0] for line in lines if line.endswith("FAILED")] == ["windup", "time"]
    assert len(lines) == 1 + sum(map(len, SCENARIO_METRICS.values()))
    signs = [line.split()[-2] for line in lines if line.startswith(("held", "steps"))]
    assert signs == [">=", "<="]


def test_junit_has_a_case_per_scenario_and_escapes_text() -> None:
    judgement, _ = bad_judgement()
    suite = ElementTree.fromstring(as_junit(judgement, "a \x00 & b"))
    cases = {case.get("name"): case for case in suite}
    assert list(cases) == list(SCENARIO_METRICS)
    failed = [name for name, case in cases.items() if case.find("failure") is not None]
    assert failed == ["windup"] and suite.get("failures") == "1"
    assert suite.get("tests") == str(len(SCENARIO_METRICS))
    assert str(cases["windup"].find("failure").text).count("stop it there") == 2
    failures = [
        Failure("ramp", "figure 2, at most 1", Cause("gains", "tune \x00 them")),
        Failure("ramp", "figure 3, at most 1", Cause("windup", "stop it")),
        Failure("early", "ended", Cause("crash", "it ended")),
    ]
    finding = Finding("steps", "late", 0.0, 1.0, True, "late")
    failed = Judgement(FAILED, [finding, finding._replace(scenario="ramp")], failures)
    assert as_junit(failed, "<x>\ufffe") == (
        '<testsuite name="judge" tests="3" failures="2" errors="0">'
        '<testcase classname="&lt;x&gt;?" name="steps" />'
        '<testcase classname="&lt;x&gt;?" name="ramp"><failure type="failed"'
        ' message="figure 2, at most 1: tune ? them">figure 2, at most 1: tune ? them\n'
        "figure 3, at most 1: stop it</failure></testcase>"
        '<testcase classname="&lt;x&gt;?" name="early"><failure type="failed"'
        ' message="ended: it ended">ended: it ended</failure></testcase></testsuite>'
    )
    said = ElementTree.fromstring(
        as_junit(judge([], LIMITS, "\x08\t\n\x0b\x0c\x0e\x1f \uffff"), "x")
    )
    assert said[0][0].text == "?\t\n???? ?"
    assert as_junit(judge([], LIMITS, "no \x0b <master>"), "x") == (
        '<testsuite name="judge" tests="1" failures="0" errors="1">'
        '<testcase classname="x" name="judge"><error type="not judged"'
        ' message="no ? &lt;master&gt;">no ? &lt;master&gt;</error></testcase></testsuite>'
    )


def test_csv_has_a_row_per_controller_and_escapes_formulas() -> None:
    findings = [
        Finding("steps", "late", 0.123456789, 1.0, True, "late"),
        Finding("ramp", "late", None, 1.0, True, "late"),
    ]
    failures = [
        Failure("steps", "what", Cause(flaw, f"because of {flaw}"))
        for flaw in ("crash", "gains", "crash")
    ]
    judgements = [
        ("=1+1", Judgement(FAILED, findings, failures, "no reason")),
        ("b,c", Judgement(NOT_JUDGED, [], [], "-no")),
    ]
    text = as_csv(judgements, {"ramp": ["late"], "steps": ["late", "effort"]}, "node")
    assert text.splitlines() == [
        "node,verdict,flaws,why,ramp.late,steps.late,steps.effort",
        '\'=1+1,failed,"crash, gains",because of crash; because of gains,,0.123457,',
        '"b,c",not judged,,\'-no,,,',
    ]
    head = as_csv([], SCENARIO_METRICS).split(",")
    assert head[:5] == ["controller", "verdict", "flaws", "why", "held.set_point_response"]
    assert len(head) == 4 + sum(map(len, SCENARIO_METRICS.values()))
    cells = [text_cell(one) for one in ("\ra", "\ta", "+a", "@a", "a\r-", "")]
    assert cells == ["'\ra", "'\ta", "'+a", "'@a", "a\r-", ""]


def test_the_picture_shows_every_scenario_and_marks_failures() -> None:
    judgement, records = bad_judgement()
    records = [*records, Record(STEPS, ENDED)]
    svg = as_svg(records, "<a> & b", ["windup"])
    root = ElementTree.fromstring(svg)
    panels = root.findall(f"{SVG}g")
    assert len(panels) == len(records) == len({panel.get("transform") for panel in panels})
    headings = [panel.find(f"{SVG}text") for panel in panels]
    wrong = [one.text for one in headings if one.get("fill") != "black"]
    assert len(wrong) == 1 and wrong[0].startswith("windup: ")
    assert all(len(list(panel.iter(f"{SVG}polyline"))) == 3 for panel in panels[:-1])
    assert "nan" not in svg.replace("nan: NaN", "").lower().replace("nan as", "")
    assert len(svg) < 400_000
    # The jump of the input is in the picture, however many rows are left out.
    set_point = list(panels[list(SCENARIO_METRICS).index("steps")].iter(f"{SVG}polyline"))[0]
    asked = {point.split(",")[1] for point in (set_point.get("points") or "").split()}
    assert len(asked) == 5  # a height for each set point
    windup = panels[list(SCENARIO_METRICS).index("windup")]
    points = list(windup.iter(f"{SVG}polyline"))[2].get("points").split()
    heights = [float(point.split(",")[1]) for point in points]
    assert max(heights) - min(heights) > 10.0


def test_picture_has_a_panel_for_each_record_in_rows_of_three(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    drawn = []
    monkeypatch.setattr(picture, "plot", lambda *panel: drawn.append(panel) or ["<plot/>"])
    rows = [Row(0.5, 4.0, 3.0, -2.0), Row(0.75, 5.0, 3.5, 0.5)]
    small = [row._replace(input=0.25 * row.input) for row in rows]
    still = [row._replace(input=0.0) for row in rows]
    names = {"ramp": rows, "held": small, "rate": still, "early": small}
    records = [Record(BY_NAME[name], rows=drawn_rows) for name, drawn_rows in names.items()]
    records.append(Record(BY_NAME["nan"], "<ended>"))
    panels = [
        f'<g transform="translate({x} {y})">\n<text y="16.0" fill="{colour}">{name}:'
        f" {BY_NAME[name].about}</text>\n"
        '<g transform="translate(0 22)">\n<plot/>\n</g>\n'
        '<g transform="translate(0 136)">\n<plot/>\n</g>\n</g>'
        for name, x, y, colour in (
            ("ramp", 34, 34, "black"),
            ("held", 360, 34, "#b00020"),
            ("rate", 686, 34, "black"),
            ("early", 34, 232, "black"),
        )
    ]
    assert as_svg(records, "<a> & b", ["held"]) == "\n".join(
        [
            '<svg xmlns="http://www.w3.org/2000/svg" width="978" height="430"'
            ' viewBox="0 0 978 430" font-family="sans-serif" font-size="10">',
            '<rect width="978" height="430" fill="white"/>',
            '<text x="34.0" y="16" font-size="13">&lt;a&gt; &amp; b</text>',
            '<text x="34.0" y="30"><tspan fill="#888888">set point, rad/s</tspan>'
            '  <tspan fill="#0072b2">motor, rad/s</tspan>'
            '  <tspan fill="#d55e00">input</tspan></text>',
            *panels,
            '<g transform="translate(360 232)">',
            '<text y="16.0" fill="black">nan: NaN as a measurement, and as a set point</text>',
            '<text y="42.0" fill="#b00020">&lt;ended&gt;</text>',
            "</g>",
            "</svg>\n",
        ]
    )
    times = [0.5, 0.75]
    speeds = [
        Curve("", "#888888", times, [4.0, 5.0]),
        Curve("", "#0072b2", times, [3.0, 3.5]),
    ]
    assert drawn[0] == (Panel("", speeds, 90.0), 260.0, 0.0, 2.0)
    inputs = [Curve("", "#d55e00", times, [-2.0, 0.5])]
    ends = [panel[0].limits for panel in drawn[1::2]]
    assert ends == [pytest.approx((-end, end)) for end in (2.2, 0.55, 1.2, 1.2)]
    assert drawn[1] == (Panel("", inputs, 40.0, ends[0]), 260.0, 0.0, 2.0)


def heights_of_input(record: Record) -> List[float]:
    """Return the heights of the points of the input's curve in the picture of a scenario."""
    panel = ElementTree.fromstring(as_svg([record], "title", [])).find(f"{SVG}g")
    tops = [one.get("transform").split()[1].rstrip(")") for one in panel.findall(f"{SVG}g")]
    assert float(tops[0]) > 16.0 and float(tops[1]) - float(tops[0]) > 90.0 + 16.0
    points = list(panel.iter(f"{SVG}polyline"))[2].get("points").split()
    return [float(point.split(",")[1]) for point in points]


def test_picture_of_a_scenario_that_failed_shows_it_until_then() -> None:
    record = play_one("ramp", pi())._replace(failure=ENDED)
    svg = as_svg([record], "title", [])
    assert svg.count("<polyline") == 3
    assert float(ElementTree.fromstring(svg).get("height", "0")) > 200.0


def test_picture_shows_an_input_far_beyond_the_limit_of_the_motor() -> None:
    record = play_one("windup", pi(output_min=-255.0, output_max=255.0, anti_windup="none"))
    heights = heights_of_input(record)
    assert len(set(heights)) > 100  # not flat at the end of an axis


def test_picture_of_a_held_motor_shows_small_answers() -> None:
    heights = heights_of_input(play_one("rate", pi(kp=0.01, ki=0.01)))
    assert max(heights) - min(heights) > 20.0


def test_batch_page_counts_verdicts_and_escapes_html() -> None:
    rows = [
        {"controller": "a/<b>", "verdict": PASSED, "flaws": "", "why": ""},
        {"controller": "c", "verdict": FAILED, "flaws": "gains, windup", "why": "<script>"},
        {"controller": "d", "verdict": NOT_JUDGED, "flaws": "", "why": "no"},
        {"controller": "e", "verdict": FAILED, "flaws": "windup", "why": "&"},
    ]
    head, *body = as_html(rows, "controller", {"c": ["c d.svg", "c.txt"]}).split("</head>")
    assert head.startswith(
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>Class</title>\n<style>'
    )
    assert "".join(body).splitlines() == [
        "<body><h1>4 controllers</h1><p>1 passed, 2 failed, 1 not judged</p>",
        "<p>Flaws: windup (2), gains (1)</p>",
        "<table><tr><th>controller</th><th>verdict</th><th>why</th><th></th></tr>",
        '<tr><td>a/&lt;b&gt;</td><td class="passed">passed</td><td></td><td></td></tr>',
        '<tr><td>c</td><td class="failed">failed</td><td>&lt;script&gt;</td>'
        '<td><a href="c%20d.svg">svg</a> <a href="c.txt">txt</a></td></tr>',
        '<tr><td>d</td><td class="not-judged">not judged</td><td>no</td><td></td></tr>',
        '<tr><td>e</td><td class="failed">failed</td><td>&amp;</td><td></td></tr>',
        "</table></body></html>",
    ]
    students = [{"student": "<Zoe>", "node": "a", "verdict": PASSED, "flaws": "", "why": ""}]
    assert as_html(students, "node", {}).splitlines()[1:] == [
        f"{head.splitlines()[1]}</head><body><h1>1 nodes</h1>"
        "<p>1 passed, 0 failed, 0 not judged</p>",
        "<table><tr><th>student</th><th>node</th><th>verdict</th><th>why</th><th></th></tr>",
        '<tr><td>&lt;Zoe&gt;</td><td>a</td><td class="passed">passed</td><td></td><td></td></tr>',
        "</table></body></html>",
    ]


def test_page_shows_passed_in_green_and_failed_in_red() -> None:
    row = {"controller": "a", "verdict": PASSED, "flaws": "", "why": ""}
    page = as_page_of_student(row, "controller", "", [])
    for verdict, is_green in (("passed", True), ("failed", False)):
        colour = page.split(f".{verdict}{{color:#")[1][:6]
        assert (int(colour[2:4], 16) > int(colour[:2], 16)) is is_green


def test_page_of_a_student_has_verdict_picture_and_text() -> None:
    row = {"student": "<Zoe>", "node": "a", "verdict": NOT_JUDGED, "why": "<no>"}
    head, *body = as_page_of_student(row, "node", "a < b\nc", ["z é.svg"]).split("<style>")
    assert head == (
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">\n<title>&lt;Zoe&gt; a</title>'
    )
    assert "".join(body).partition("</head>\n")[2].splitlines() == [
        "<body><h1>&lt;Zoe&gt; a</h1>",
        '<p class="not-judged">not judged: &lt;no&gt;</p>',
        '<p><img src="z%20%C3%A9.svg" alt="all scenarios"></p>',
        "<pre>a &lt; b",
        "c</pre></body></html>",
    ]
    # One who passed has no reason, and without a roster there is no name.
    passed = {"node": "a", "verdict": PASSED, "why": ""}
    page = as_page_of_student(passed, "node", "", []).partition("</head>\n")[2]
    assert page == '<body><h1>a</h1>\n<p class="passed">passed</p>\n<pre></pre></body></html>\n'
