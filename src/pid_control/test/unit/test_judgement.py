"""Tests of limits, diagnosis and reports."""

import csv
import functools
import io
import math
from typing import Dict, List, Optional
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as some

from pid_control.judging.controller_judgement import is_fatal, judge
from pid_control.verdicts.batch_page import as_html, as_page_of_student
from pid_control.judging.diagnosis import FLAWS, cause_of, cause_of_failure
from pid_control.verdicts.judgement import FAILED, NOT_JUDGED, PASSED, found, number
from pid_control.verdicts.limits import LimitsError, merged, read_limits
from pid_control.judging.evidence import ControllerEvidence, Law
from pid_control.judging.metrics import METRICS, SCENARIO_METRICS
from pid_control.judging.picture import as_svg
from pid_control.judging.record import (
    ENDED,
    NOT_CONNECTED,
    RESTLESS,
    SILENT,
    WRITES_WITHOUT_END,
    Pause,
    Record,
)
from pid_control.verdicts.reports import as_csv, as_junit, as_sentences, as_table, text_cell
from pid_control.judging.scenarios import BY_NAME
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


@pytest.mark.parametrize(
    "text, says",
    [
        ("steps: {overshoot: -1}", "steps: overshoot: -1 must be a number of at least 0, or null"),
        ("steps: {overshoot: lots}", "steps: overshoot: 'lots' must be a number"),
        ("steps: {overshoot: true}", "steps: overshoot: True must be a number"),
        ("steps: {overshoot: .nan}", "steps: overshoot: nan must be a number"),
        ("steps: {overshoot: .inf}", "steps: overshoot: inf must be a number"),
        (f"steps: {{overshoot: {10**400}}}", "steps: overshoot: 10+ must be a number"),
        ("steps: {overshoot: [1]}", r"steps: overshoot: \[1\] must be a number"),
        ("steps: {overshot: 1}", "steps: overshot: not measured there, but rise_time, overshoot"),
        ("step: {overshoot: 1}", "step: unknown scenario; choose from held, rate, steps"),
        ("steps: 5", "steps: must hold limits by name, not 5"),
        ("[steps]", r"it must hold scenarios, each with its limits, not \['steps'\]"),
        ("steps: {overshoot: 1", "it is not YAML"),
        ("steps: {overshoot: 1}\nsteps: {late: 1}", "line 2: duplicate key steps"),
        ("steps:\n  late: 1\n  late: 2\n", "line 3: duplicate key late"),
        ("7: {late: 1}", "line 1: 7 is not a name"),
        ("steps: !!python/object/apply:os.getcwd []", "it is not YAML"),
        ("a: &a [*a]", "it is not YAML"),
        ("steps: {overshoot: 2001-99-99}", "it is not YAML"),
    ],
)
def test_read_limits_invalid_text_names_the_problem(text: str, says: str) -> None:
    with pytest.raises(LimitsError, match=says):
        read_limits(text, SCENARIO_METRICS)


@given(some.text(max_size=40))
def test_read_limits_any_text_raises_only_limits_error(text: str) -> None:
    try:
        read_limits(text, SCENARIO_METRICS)
    except LimitsError as error:
        assert str(error)


def test_a_good_controller_passes() -> None:
    judgement = judge(play_all(pi()), LIMITS)
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


def test_judge_p_controller_reports_no_integral() -> None:
    judgement = judge(play_all(pi(kp=0.1, ki=0.0)), LIMITS)
    assert judgement.flaws() == ["no integral"]


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
        ({}, "steps", "chatter", "chatter"),
        ({}, "steps", "overshoot", "gains"),
        ({}, "steps", "effort", "gains"),
    ],
)
def test_cause_of_returns_the_cause_that_the_figures_show(
    figures: Dict[tuple, Optional[float]], scenario: str, metric: str, flaw: str
) -> None:
    assert cause_of(scenario, metric, figures).flaw == flaw


def test_cause_of_evidence_decides_between_rivals() -> None:
    measured = ControllerEvidence(was_measured=True)
    cause = cause_of("steps", "overshoot", {}, measured)
    assert cause.sentence.endswith("kp and ki, or a fault that the scenario held would show")
    cause = cause_of("steps", "peak_input", {}, measured)
    assert cause.sentence == "the input is within -1 and 1, but beyond the limit for it"
    for beyond, side in ((("above", "below"), ""), (("above",), " above"), (("below",), " below")):
        cause = cause_of("steps", "peak_input", {}, measured._replace(beyond=beyond))
        assert cause.sentence == f"the input is not limited{side}: keep it within -1 and 1"
    for topic in ("set_point", "motor_output"):
        inverse = measured._replace(wrong_signs=(topic,))
        for metric in ("set_point_response", "output_response", "settling_time"):
            cause = cause_of("held", metric, {}, inverse)
            assert cause.sentence.startswith(f"the sign of {topic} is wrong: ")
    derivative = measured._replace(was_probed=True, has_derivative=True)
    cause = cause_of("steps", "chatter", {}, derivative)
    assert (cause.flaw, cause.sentence) == (
        "chatter",
        "the input chatters: one of: unsuitable kp, ki or kd, or a derivative without a filter",
    )
    lacking = measured._replace(was_probed=True, lacks_integral=True)
    for metric, flaw in (
        ("rise_time", "no integral"),
        ("settling_time", "no integral"),
        ("steady_error", "no integral"),
        ("absolute_error", "no integral"),
        ("overshoot", "unexplained"),
        ("chatter", "unexplained"),
    ):
        assert cause_of("steps", metric, {}, lacking).flaw == flaw
    law = Law(0.08, 1.5, 0.01)
    winding = measured._replace(was_probed=True, winds_up=True, law=law)
    for scenario in ("missing", "early", "load"):
        cause = cause_of(scenario, "recovery_time", {}, winding, lambda *_: False)
        assert cause.flaw == ("unexplained" if scenario == "load" else "windup")
    per_turn = measured._replace(was_probed=True, grows_per_turn=True, law=law)
    for metric, flaw in (("settling_time", "interval"), ("overshoot", "gains")):
        assert cause_of("steps", metric, {}, per_turn, lambda *_: True).flaw == flaw


def test_cause_of_every_metric_is_known() -> None:
    for scenario, names in SCENARIO_METRICS.items():
        assert names, scenario
        for name in names:
            beyond = -1.0 if METRICS[name].is_least else 1e9
            assert cause_of(scenario, name, {(scenario, name): beyond}).flaw in FLAWS


STEPS = BY_NAME["steps"]


@pytest.mark.parametrize(
    "record, flaw, says",
    [
        (Record(STEPS, ENDED, "KeyError: 9"), "crash", "ended by itself: KeyError: 9"),
        (Record(STEPS, WRITES_WITHOUT_END), "endless output", "without end"),
        (Record(STEPS, RESTLESS), "restless", "computes without a pause"),
        (Record(STEPS, RESTLESS, answers=[(0.0, 0.0)] * 900), "flood", "sends without a pause"),
        (Record(STEPS, SILENT, "waiting"), "silent", "sends nothing on motor_input: waiting"),
        (
            Record(STEPS, SILENT, "waiting", answers=[(0.1, 0.0), (1.5, 0.0)]),
            "crash",
            "sends nothing after 1.50 s: waiting",
        ),
        (
            Record(STEPS, NOT_CONNECTED, "hi", missing=["motor_input"], hint="it publishes /u"),
            "silent",
            "does not publish motor_input; it publishes /u: hi",
        ),
        (
            Record(STEPS, NOT_CONNECTED, "hi", missing=["motor_output", "set_point"], hint="why"),
            "not connected",
            "does not subscribe to motor_output and set_point; why: hi",
        ),
    ],
)
def test_cause_of_failure_names_the_reason(record: Record, flaw: str, says: str) -> None:
    cause = cause_of_failure(record)
    assert cause.flaw == flaw and says in cause.sentence
    judgement = judge([record], LIMITS)
    assert (judgement.verdict, judgement.flaws()) == (FAILED, [flaw])
    assert is_fatal(record, LIMITS) == (flaw != "crash" or not record.answers)


def test_judge_machine_clock_is_not_judged() -> None:
    record = play_one("held", pi())._replace(pauses=[Pause(5.2, 0.5, 1.0, 25)])
    judgement = judge([record], LIMITS)
    assert (judgement.verdict, judgement.status) == (NOT_JUDGED, 125)
    assert "judge it with --real-time" in judgement.reason
    assert is_fatal(record, LIMITS)
    # Whatever else it does.
    both = judge([record, Record(STEPS, ENDED, "KeyError: 9")], LIMITS)
    assert (both.verdict, both.reason) == (NOT_JUDGED, judgement.reason)


def test_judge_division_by_0_with_a_simulated_clock_is_not_judged() -> None:
    words = "ZeroDivisionError: float division by zero (controller.py, line 38)"
    record = Record(STEPS, ENDED, words, is_simulated=True)
    judgement = judge([record], LIMITS)
    assert (judgement.verdict, judgement.flaws()) == (NOT_JUDGED, ["division by 0"])
    assert words in judgement.reason and "judge it with --real-time" in judgement.reason
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
    crashed = judge([Record(STEPS, ENDED, "\x00")], LIMITS)
    assert "by itself: ?" in str(ElementTree.fromstring(as_junit(crashed, "x"))[0][0].text)
    none = ElementTree.fromstring(as_junit(judge([], LIMITS, "no <master>"), "x"))
    assert (none.get("tests"), none.get("errors")) == ("1", "1")
    assert none[0].find("error").get("message") == "no <master>"


def test_csv_has_a_row_per_controller_and_escapes_formulas() -> None:
    judgement, _ = bad_judgement()
    rows = list(
        csv.DictReader(
            io.StringIO(as_csv([("=1+1", judgement), ("b", judge([], {}))], SCENARIO_METRICS))
        )
    )
    assert [row["controller"] for row in rows] == ["'=1+1", "b"]
    assert (rows[0]["verdict"], rows[0]["flaws"]) == ("failed", "windup")
    assert float(rows[0]["windup.leave_time"]) > 0.5 and rows[1]["windup.leave_time"] == ""
    assert [text_cell(one) for one in ("\ra", "\ta", "a\r")] == ["'\ra", "'\ta", "a\r"]


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
    page = as_html(rows, "controller", {"c": ["c d.svg", "c.txt"]})
    assert "<h1>4 controllers</h1><p>1 passed, 2 failed, 1 not judged</p>" in page
    assert "<p>Flaws: windup (2), gains (1)</p>" in page
    assert '<a href="c%20d.svg">svg</a> <a href="c.txt">txt</a>' in page
    assert "<script>" not in page and "a/&lt;b&gt;" in page
    assert '<td class="not-judged">not judged</td>' in page


def test_page_shows_passed_in_green_and_failed_in_red() -> None:
    row = {"controller": "a", "verdict": PASSED, "flaws": "", "why": ""}
    page = as_page_of_student(row, "controller", "", [])
    for verdict, is_green in (("passed", True), ("failed", False)):
        colour = page.split(f".{verdict}{{color:#")[1][:6]
        assert (int(colour[2:4], 16) > int(colour[:2], 16)) is is_green


def test_page_of_a_student_who_passed_has_no_reason() -> None:
    row = {"controller": "a", "verdict": PASSED, "flaws": "", "why": ""}
    assert '<p class="passed">passed</p>' in as_page_of_student(row, "controller", "", [])


def test_every_metric_has_a_label_and_its_unit() -> None:
    assert all(metric.label for metric in METRICS.values())
    units = {name: metric.unit for name, metric in METRICS.items()}
    times = {"rise_time", "settling_time", "leave_time", "recovery_time"}
    sums = {"standstill_jump", "processor", "effort"}
    assert {name for name, unit in units.items() if unit == "s"} == times | sums
    errors = {"steady_error", "tracking_error"}
    assert {name for name, unit in units.items() if unit == "rad/s"} == errors
    answers = {"set_point_response", "output_response", "kick"}
    assert {name for name, unit in units.items() if unit == "1/(rad/s)"} == answers
    assert (units["overshoot"], units["absolute_error"]) == ("%", "rad")
