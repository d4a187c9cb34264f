"""Diagnosis: the most likely cause of a figure beyond its limit."""

import math
from typing import Callable, Dict, NamedTuple, Optional, Sequence, Tuple

from pid_control.judging.record import (
    ENDED,
    NOT_CONNECTED,
    RESTLESS,
    SILENT,
    WRITES_WITHOUT_END,
    Record,
)

#: Figures by scenario and metric.
Figures = Dict[Tuple[str, str], Optional[float]]

#: Messages during a pause of the clock that are more than any loop with a rate sends.
_FLOOD = 200


class Cause(NamedTuple):
    """The cause of a failure.

    :ivar flaw: short name
    :ivar sentence: description and remedy
    """

    flaw: str
    sentence: str


class _Rule(NamedTuple):
    """A cause, and the condition under which it is likely.

    :ivar cause: the cause
    :ivar metrics: metrics that it can affect
    :ivar holds: returns True if all figures agree with the cause
    :ivar scenarios: scenarios in which it can appear; empty for all
    """

    cause: Cause
    metrics: Sequence[str]
    holds: Callable[[Figures], bool]
    scenarios: Sequence[str] = ()


def _figure(figures: Figures, scenario: str, metric: str, default: float) -> float:
    value = figures.get((scenario, metric))
    return default if value is None else value


def _is_deaf_to(metric: str) -> Callable[[Figures], bool]:
    return lambda figures: abs(_figure(figures, "held", metric, 1.0)) < 1e-6


def _has_wrong_sign(figures: Figures) -> bool:
    return _figure(figures, "held", "output_response", 1.0) < 0.0


def _computes_on(figures: Figures) -> bool:
    return _figure(figures, "held", "standstill_rest", 1.0) < 0.5


def _floods(figures: Figures) -> bool:
    answers = _figure(figures, "held", "standstill_answers", 0.0)
    return _computes_on(figures) and answers > _FLOOD


def _runs_on(figures: Figures) -> bool:
    return _figure(figures, "held", "standstill_answers", 0.0) > 1.0


def _counts_on(figures: Figures) -> bool:
    return _figure(figures, "held", "standstill_jump", 0.0) > 0.05


def _has_no_integral(figures: Figures) -> bool:
    # Only with an integral can its growth at two rates be compared.
    return ("rate", "interval_error") in figures and figures["rate", "interval_error"] is None


def _winds_up(figures: Figures) -> bool:
    return _figure(figures, "windup", "leave_time", 0.0) > 0.1


def _is_late(figures: Figures) -> bool:
    late = (_figure(figures, scenario, "late", 0.0) for scenario in ("held", "steps"))
    return max(late) > 0.05


def _has_wrong_interval(figures: Figures) -> bool:
    return _figure(figures, "rate", "interval_error", 0.0) > 0.1


def _keeps_nan(figures: Figures) -> bool:
    is_well_otherwise = math.isfinite(_figure(figures, "steps", "settling_time", 0.0))
    never_recovers = math.isinf(_figure(figures, "nan", "recovery_time", 0.0))
    return _figure(figures, "nan", "not_finite", 0.0) > 0.0 or (
        never_recovers and is_well_otherwise
    )


def _always(_figures: Figures) -> bool:
    return True


_STATIONARY = ("rise_time", "settling_time", "steady_error", "recovery_time", "tracking_error")
_SLOW = (*_STATIONARY, "absolute_error")
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
_MACHINE_CLOCK = Cause(
    "machine clock",
    "it goes by the machine's clock (time.time(), time.sleep()), not by ROS's"
    " (rospy.get_time(), rospy.Rate): judge it with --real-time",
)
_FLOOD_CAUSE = Cause("flood", "it sends without a pause: a loop without rospy.Rate")
_RESTLESS_CAUSE = Cause("restless", "it computes without a pause: a loop without rospy.Rate")
#: The first rule that agrees with all figures gives the likely cause.
_RULES = (
    _Rule(_FLOOD_CAUSE, _HELD, _floods),
    _Rule(_RESTLESS_CAUSE, _HELD, _computes_on),
    _Rule(_MACHINE_CLOCK, _HELD, _runs_on),
    _Rule(
        Cause("too seldom", "it answers too seldom: its loop is far below 100 Hz"),
        (*_HELD, *_SLOW, "interval_error", "overshoot", "chatter"),
        _is_late,
    ),
    _Rule(_MACHINE_CLOCK, _HELD, _counts_on),
    _Rule(
        Cause("stale", "the input does not depend on motor_output: its callback's value is lost"),
        ("output_response", "set_point_response"),
        _is_deaf_to("output_response"),
    ),
    _Rule(
        Cause("deaf", "the input does not depend on set_point: its callback's value is not used"),
        ("set_point_response",),
        _is_deaf_to("set_point_response"),
    ),
    _Rule(
        Cause("sign", "the sign is wrong: the error is the set point less the output"),
        ("output_response", "set_point_response"),
        _has_wrong_sign,
    ),
    _Rule(
        Cause("too slow", "a turn of its loop takes longer than its period"),
        ("processor",),
        _always,
    ),
    _Rule(
        Cause("nan", "what is not a number stays in its state: leave such messages out"),
        ("not_finite", "recovery_time"),
        _keeps_nan,
        ("nan",),
    ),
    _Rule(
        Cause("no clamp", "the input is not limited: keep it within -1 and 1"),
        ("peak_input",),
        _always,
    ),
    _Rule(
        Cause(
            "windup",
            "the integral goes on growing while the output is limited; stop it there",
        ),
        ("leave_time", "recovery_time"),
        _winds_up,
        ("windup", "missing", "early"),
    ),
    _Rule(
        Cause(
            "interval",
            "the integral does not go by the time that passes: dt is a constant, not measured",
        ),
        ("interval_error",),
        _always,
    ),
    _Rule(
        Cause(
            "derivative kick",
            "the derivative is that of the error, which a step of the set point makes leap:"
            " take that of the output",
        ),
        ("kick",),
        _always,
    ),
    _Rule(
        Cause("no integral", "P alone leaves an error, as without one the input is 0: add I"),
        _SLOW,
        _has_no_integral,
    ),
    _Rule(
        Cause("interval", "the integral is as slow as its constant dt is wrong"),
        _SLOW,
        _has_wrong_interval,
    ),
    _Rule(
        Cause("chatter", "the input trembles: the gains are too large, or D is not filtered"),
        ("chatter",),
        _always,
    ),
    _Rule(
        Cause("gains", "it swings: ki is too large for kp, or both are too large"),
        ("overshoot",),
        _always,
    ),
    _Rule(Cause("gains", "it is slow, or swings for long: tune kp and ki"), _SLOW, _always),
    _Rule(
        Cause("gains", "the input is larger than it need be: tune kp and ki"), ("effort",), _always
    ),
)


def cause_of(scenario: str, metric: str, figures: Figures) -> Cause:
    """Return the most likely cause of a figure beyond its limit.

    :param scenario: name of the scenario
    :param metric: name of the metric
    :param figures: all figures of the controller
    """
    for rule in _RULES:
        is_possible = metric in rule.metrics and scenario in (rule.scenarios or [scenario])
        if is_possible and rule.holds(figures):
            return rule.cause
    return Cause("other", "no cause is known for this")


def cause_of_failure(record: Record) -> Cause:
    """Return the cause of a scenario that ended early.

    :param record: a record with a failure
    """
    words = f": {record.words}" if record.words else ""
    if record.failure == ENDED:
        return Cause("crash", f"the controller ended by itself{words}")
    if record.failure == WRITES_WITHOUT_END:
        return Cause("endless output", "the controller writes to its log without end")
    if record.failure == RESTLESS:
        return _FLOOD_CAUSE if len(record.answers) > _FLOOD else _RESTLESS_CAUSE
    if record.failure == SILENT and record.answers:
        latest = record.answers[-1][0]
        return Cause("crash", f"the controller sends nothing any more after {latest:.2f} s{words}")
    if record.failure == SILENT:
        return Cause("silent", f"the controller sends nothing on motor_input{words}")
    assert record.failure == NOT_CONNECTED, record.failure
    missing = " and ".join(name for name in record.missing if name != "motor_input")
    if "motor_input" in record.missing:
        hint = f"; {record.hint}" if record.hint else ""
        return Cause("silent", f"the controller does not publish motor_input{hint}{words}")
    return Cause("not connected", f"the controller does not subscribe to {missing}{words}")
