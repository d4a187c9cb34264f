"""Diagnosis of a controller: the fault that explains a metric beyond its limit.

A cause is stated as a fact only if the records rule out all others; else all are listed, or the
cause is reported as unknown.
"""

import math
from typing import Callable, Dict, Optional, Tuple

from pid_control.judging.evidence import ControllerEvidence, faultless_figures
from pid_control.judging.record import (
    ENDED,
    NOT_CONNECTED,
    RESTLESS,
    SILENT,
    WRITES_WITHOUT_END,
    Record,
)
from pid_control.verdicts.judgement import Cause

#: Figures by scenario and metric.
Figures = Dict[Tuple[str, str], Optional[float]]
#: Returns True if a figure breaks its limit: scenario, metric, figure.
IsBroken = Callable[[str, str, Optional[float]], bool]

#: A loop that sends more messages than this while the clock is paused has no rate.
_FLOOD = 200


#: Flaws that stop the judgement: the other scenarios would take too long, or prove nothing.
FATAL = (
    "not connected",
    "silent",
    "endless output",
    "machine clock",
    "flood",
    "restless",
    "too slow",
)
#: Flaws, worst first: each may be the reason of those after it.
FLAWS = (
    "crash",
    "division by 0",
    *FATAL,
    "too seldom",
    "late start",
    "no answer",
    "stale",
    "deaf",
    "sign",
    "units",
    "no clamp",
    "nan",
    "windup",
    "windup or delay",
    "interval",
    "derivative kick",
    "no integral",
    "chatter",
    "gains",
    "unexplained",
)

_SLOW = (
    "rise_time",
    "settling_time",
    "steady_error",
    "recovery_time",
    "tracking_error",
    "absolute_error",
)
#: Metrics of a loop that is closed.
_CLOSED_LOOP = (*_SLOW, "overshoot", "effort", "chatter", "leave_time")
_HELD = (
    "standstill_answers",
    "standstill_rest",
    "standstill_jump",
    "set_point_response",
    "output_response",
    "kick",
    "processor",
    "late",
)
_RESPONSES = ("set_point_response", "output_response")

_MACHINE_CLOCK = Cause(
    "machine clock",
    "it uses the machine's clock (time.time(), time.sleep()), not ROS's"
    " (rospy.get_time(), rospy.Rate): judge it with --real-time",
)
#: Its sides beyond ±1, in words.
_BEYOND: Dict[Tuple[str, ...], str] = {("above",): "goes above 1", ("below",): "goes below -1"}
_FLOOD_CAUSE = Cause("flood", "it sends without a pause: a loop without rospy.Rate")
_RESTLESS_CAUSE = Cause("restless", "it computes without a pause: a loop without rospy.Rate")
_SELDOM = Cause("too seldom", "it answers too seldom: its loop is far slower than 100 Hz")
_IGNORES = {
    "motor_output": Cause(
        "stale", "the input does not depend on motor_output: its callback's value is lost"
    ),
    "set_point": Cause(
        "deaf", "the input does not depend on set_point: its callback's value is not used"
    ),
}
_NO_ANSWER = Cause(
    "no answer",
    "the input never changes: one of: its gains are 0 (are its parameters"
    " loaded, by its launch file?), or the values of its callbacks are lost",
)
_SIGN = Cause("sign", "the sign is wrong: the error is the set point less the output")
_NO_INTEGRAL = Cause("no integral", "P alone leaves a steady error: add I")
_WINDUP = Cause("windup", "the integral keeps growing while the output is limited; stop it there")
_INTERVAL = "the integral does not follow the elapsed time: dt is a constant, not measured"


def cause_of(
    scenario: str,
    metric: str,
    figures: Figures,
    evidence: ControllerEvidence = ControllerEvidence(),
    is_broken: IsBroken = lambda scenario, metric, figure: True,
) -> Cause:
    """Return the cause of a figure beyond its limit.

    :param scenario: name of the scenario
    :param metric: name of the metric
    :param figures: all figures of the controller
    :param evidence: evidence about its control law
    :param is_broken: returns True if another figure would break that limit, too
    """
    clock = _clock_cause(metric, figures)
    if clock is not None:
        return clock
    if metric == "processor":
        return Cause("too slow", "one loop iteration takes longer than its period")
    if metric == "late":
        return _SELDOM
    return (
        _law_cause(metric, figures, evidence)
        or _limit_cause(scenario, metric, figures, evidence)
        or _integral_cause(metric, figures, evidence)
        or _loop_cause(scenario, metric, figures, evidence, is_broken)
    )


def _figure(figures: Figures, scenario: str, metric: str, default: float) -> float:
    value = figures.get((scenario, metric))
    return default if value is None else value


def _clock_cause(metric: str, figures: Figures) -> Optional[Cause]:
    if metric not in _HELD:
        return None
    answers = _figure(figures, "held", "standstill_answers", 0.0)
    if _figure(figures, "held", "standstill_rest", 1.0) < 0.5:
        return _FLOOD_CAUSE if answers > _FLOOD else _RESTLESS_CAUSE
    has_moved = _figure(figures, "rate", "standstill_jump", 0.0) > 0.05
    is_of_clock = metric in ("standstill_answers", "standstill_jump", "late")
    if answers > 1.0 or (has_moved and is_of_clock):
        return _MACHINE_CLOCK
    return None


def _law_cause(metric: str, figures: Figures, evidence: ControllerEvidence) -> Optional[Cause]:
    """Return a fault of the control law itself, which explains all other faults."""
    if metric not in (*_RESPONSES, *_CLOSED_LOOP):
        return None
    if evidence.starts_at is not None:
        return Cause(
            "late start",
            f"the input is constant for the first {evidence.starts_at:.0f} s or so of a run: one"
            " of: the controller waits, although it sends already, or its answers are that late",
        )
    if len(evidence.ignores) > 1:
        return _NO_ANSWER
    if evidence.ignores:
        return _IGNORES[evidence.ignores[0]]
    if len(evidence.wrong_signs) > 1:
        return _SIGN
    if evidence.wrong_signs:
        topic = evidence.wrong_signs[0]
        return Cause("sign", f"the sign of {topic} is wrong: the error is set point less output")
    if evidence.wrong_above is not None:
        side = "above" if evidence.wrong_above else "below"
        return Cause("sign", f"the sign is wrong for an error {side} 0 only")
    if metric in _RESPONSES:
        return Cause("unexplained", "the input hardly depends on the error")
    if _is_late(figures) and metric != "leave_time":
        return _SELDOM
    return None


def _is_late(figures: Figures) -> bool:
    late = (_figure(figures, scenario, "late", 0.0) for scenario in ("held", "steps"))
    return max(late) > 0.05


def _limit_cause(
    scenario: str, metric: str, figures: Figures, evidence: ControllerEvidence
) -> Optional[Cause]:
    """Return a fault at the limits, or with NaN."""
    limit = evidence.own_limit
    if evidence.is_in_other_units and metric in ("peak_input", "kick", *_CLOSED_LOOP):
        if not (metric == "leave_time" and evidence.winds_up):
            return Cause(
                "units",
                f"a correct controller in other units: its input is limited to ±{limit:.6g}, the"
                f" motor's to ±1; divide it by {limit:.6g}",
            )
    if metric == "peak_input" and limit is not None:
        return Cause(
            "no clamp",
            f"the input is limited to ±{limit:.6g}, not to ±1: one of: a limit that is too wide,"
            f" or other units (divide it by {limit:.6g})",
        )
    if metric == "peak_input" and evidence.was_measured and not evidence.beyond:
        return Cause("no clamp", "the input is within -1 and 1, but beyond the limit for it")
    if metric == "peak_input":
        what = _BEYOND.get(evidence.beyond, "leaves -1 to 1")
        return Cause("no clamp", f"the input {what}: limit it")
    if scenario == "nan" and metric in ("not_finite", "recovery_time") and _keeps_nan(figures):
        what = "NaN stays in its state: ignore such messages"
        return Cause("nan", what)
    if metric == "leave_time" or (scenario == "windup" and metric == "recovery_time"):
        if _figure(figures, "windup", "leave_time", 0.0) > 0.1:
            return _WINDUP if evidence.winds_up else _windup_or_delay()
    return None


def _windup_or_delay() -> Cause:
    return Cause(
        "windup or delay",
        "the input leaves its limit late: one of: the integral grows while the output is limited,"
        " or the answer is delayed",
    )


def _keeps_nan(figures: Figures) -> bool:
    """Return whether answers are not finite, or the loop never recovers from NaN messages."""
    others = [
        value
        for (scenario, metric), value in figures.items()
        if metric == "recovery_time" and scenario != "nan" and value is not None
    ]
    others.append(_figure(figures, "steps", "settling_time", 0.0))
    is_well_otherwise = all(map(math.isfinite, others))
    never_recovers = math.isinf(_figure(figures, "nan", "recovery_time", 0.0))
    return _figure(figures, "nan", "not_finite", 0.0) > 0.0 or (
        never_recovers and is_well_otherwise
    )


def _integral_cause(metric: str, figures: Figures, evidence: ControllerEvidence) -> Optional[Cause]:
    """Return a fault of the integral or the derivative."""
    if metric == "interval_error" and evidence.grows_per_turn:
        return Cause("interval", _INTERVAL)
    if metric == "interval_error":
        return Cause(
            "interval",
            "the integral grows at another rate in a slow loop: one of: dt is a constant, or is"
            " limited",
        )
    if metric == "kick":
        return Cause(
            "derivative kick",
            "the derivative is of the error, which jumps at a step of the set point:"
            " use the derivative of the output",
        )
    if metric in _SLOW and evidence.lacks_integral:
        return _NO_INTEGRAL
    return None


def _loop_cause(
    scenario: str,
    metric: str,
    figures: Figures,
    evidence: ControllerEvidence,
    is_broken: IsBroken,
) -> Cause:
    """Return the gains as the cause if a faultless controller with them breaks the limit, too."""
    flaw, what = "gains", _SYMPTOMS.get(metric, "it is slow, or oscillates for long")
    if metric == "chatter":
        flaw = "chatter"
    if not evidence.was_probed:
        rival = "a fault that the scenario held would show"
        return Cause(flaw, f"{what}: one of: unsuitable kp and ki, or {rival}")
    law = evidence.law
    if law is None and evidence.has_derivative:
        rivals = "unsuitable kp, ki or kd, or a derivative without a filter"
        return Cause(flaw, f"{what}: one of: {rivals}")
    if law is None:
        return Cause(
            "unexplained",
            f"{what}: unknown cause, because its answers to small errors are not those of P or PI:"
            " one of: it switches, is rounded, delayed or limited, or its integral leaks",
        )
    if is_broken(scenario, metric, faultless_figures(law, scenario).get(metric)):
        if metric in _SLOW and evidence.grows_per_turn:
            return Cause("interval", "the integral is too slow, by the error of its constant dt")
        gains = f"kp {law.gain:.3g} and ki {law.growth:.3g}/s"
        return Cause(flaw, f"{what}: {gains} are unsuitable: tune them")
    if scenario in ("missing", "early", "windup") and evidence.winds_up:
        return _WINDUP
    return Cause(
        "unexplained",
        f"{what}, which its kp {law.gain:.3g} and ki {law.growth:.3g}/s do not explain: one of: the"
        " integral leaks, is reset or limited too low, or the law differs for large errors",
    )


_SYMPTOMS = {
    "overshoot": "it oscillates",
    "chatter": "the input chatters",
    "effort": "the input is larger than necessary",
}


def cause_of_failure(record: Record) -> Cause:
    """Return the cause of a scenario that ended early.

    :param record: a record with a failure
    """
    words = f": {record.words}" if record.words else ""
    if record.failure == ENDED and record.is_simulated and "ZeroDivisionError" in record.words:
        # By the machine's clock, the time between two iterations is never 0.
        return Cause(
            "division by 0",
            f"the controller ended by itself{words}; one of: its own fault, or a dt of 0, as"
            " two iterations can have the same simulated time: judge it with --real-time",
        )
    if record.failure == ENDED:
        return Cause("crash", f"the controller ended by itself{words}")
    if record.failure == WRITES_WITHOUT_END:
        return Cause("endless output", "the controller writes to its log without end")
    if record.failure == RESTLESS:
        return _FLOOD_CAUSE if len(record.answers) > _FLOOD else _RESTLESS_CAUSE
    if record.failure == SILENT and record.answers:
        latest = record.answers[-1][0]
        return Cause("crash", f"the controller sends nothing after {latest:.2f} s{words}")
    if record.failure == SILENT:
        return Cause("silent", f"the controller sends nothing on motor_input{words}")
    assert record.failure == NOT_CONNECTED, record.failure
    hint = f"; {record.hint}" if record.hint else ""
    if "motor_input" in record.missing:
        return Cause("silent", f"the controller does not publish motor_input{hint}{words}")
    missing = " and ".join(record.missing)
    return Cause("not connected", f"the controller does not subscribe to {missing}{hint}{words}")
