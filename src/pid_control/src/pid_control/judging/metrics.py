"""Metrics of a controller, computed from the records of its scenarios."""

import math
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from pid_control.judging.line_fit import Line, fit_line
from pid_control.judging.record import Record, Row
from pid_control.judging.scenarios import (
    ASKED_AT,
    BACK_AT,
    FASTER_AT,
    LITTLE,
    SLOW_AT,
    SLOW_STEP_S,
    STANDSTILL_AT,
)

#: Magnitude from which the input counts as limited: the course's limit is 1.
_LIMITED = 0.99
#: Settling band around a set point: share of the step, and its least width [rad/s].
_BAND, _LEAST_BAND = 0.05, 0.1
#: Duration of the end of a step, where the speed should be steady [s].
_END_S = 0.2
#: Longest interval of answers that are not late [s]: the loop's rate is 100 Hz.
_LATE_S = 0.025
#: Growth rate of the input below which there is no integral [1/s].
_NO_GROWTH = 1e-3
#: Time after a NaN message in which answers may be NaN [s].
_NAN_S = 0.1


class Metric(NamedTuple):
    """A metric of a record.

    :ivar label: text for reports
    :ivar unit: unit of the figure
    :ivar of: computes the figure of a record; None if not measurable
    :ivar is_least: True if the limit is a minimum, not a maximum
    """

    label: str
    unit: str
    of: Callable[[Record], Optional[float]]
    is_least: bool = False


def _windows(record: Record) -> List[Tuple[float, float, float]]:
    """Return begin and end [s] and height [rad/s] of each step of the set point."""
    corners = record.scenario.set_point
    steps = [
        (one[0], other[1] - one[1])
        for one, other in zip(corners, corners[1:])
        if one[0] == other[0] and one[1] != other[1]
    ]
    ends = [begin for begin, _ in steps[1:]] + [record.scenario.duration]
    return [(begin, end, height) for (begin, height), end in zip(steps, ends)]


def _worst(record: Record, of: Callable[[List[Row], float], Optional[float]]) -> Optional[float]:
    """Return the largest figure of all steps.

    :param of: computes the figure from the rows of a step and its height
    """
    found = [of(record.between(begin, end), height) for begin, end, height in _windows(record)]
    known = [one for one in found if one is not None]
    return max(known) if known else None


def _rise(rows: List[Row], height: float) -> Optional[float]:
    """Return the time from 10 % to 90 % of the step [s]."""
    start = rows[0].set_point - height
    shares = [((row.speed - start) / height, row.time) for row in rows]
    moments = [
        next((time for share, time in shares if share >= reached), math.inf)
        for reached in (0.1, 0.9)
    ]
    return moments[1] - moments[0] if moments[1] < math.inf else math.inf


def _overshoot(rows: List[Row], height: float) -> float:
    """Return the overshoot [% of the step]."""
    beyond = max((row.speed - row.set_point) / height for row in rows)
    return max(100.0 * beyond, 0.0)


def _settling(rows: List[Row], height: float) -> float:
    """Return the time until the speed stays in the settling band [s]."""
    return _settled_after(rows, max(_BAND * abs(height), _LEAST_BAND))


def _settled_after(rows: Sequence[Row], band: float) -> float:
    outside = [row.time for row in rows if abs(row.speed - row.set_point) > band]
    if not outside:
        return 0.0
    return outside[-1] - rows[0].time if outside[-1] < rows[-1].time else math.inf


def _steady_error(rows: List[Row], height: float) -> float:
    """Return the error at the end of a step [rad/s]."""
    last = [row for row in rows if row.time >= rows[-1].time - _END_S]
    return abs(sum(row.set_point - row.speed for row in last) / len(last))


def _absolute_error(record: Record) -> float:
    """Return the integral of the absolute error [rad]."""
    rows = record.rows
    return sum(
        abs(one.set_point - one.speed) * (other.time - one.time)
        for one, other in zip(rows, rows[1:])
    )


def _effort(record: Record) -> float:
    """Return the integral of the squared input [s]."""
    rows = record.rows
    return sum(one.input**2 * (other.time - one.time) for one, other in zip(rows, rows[1:]))


def _tracking_error(record: Record) -> float:
    """Return the mean absolute error in the second half [rad/s]."""
    half = 0.5 * record.scenario.duration
    errors = [abs(row.set_point - row.speed) for row in record.rows if row.time >= half]
    return sum(errors) / len(errors)


def _peak(record: Record) -> Optional[float]:
    values = [abs(value) for _, value in record.answers if math.isfinite(value)]
    return max(values) if values else None


def _chatter(record: Record) -> Optional[float]:
    """Return the root mean square of the changes between answers, near the end."""
    begin = record.scenario.duration - 3.0 * _END_S
    values = [value for time, value in record.answers if time >= begin and math.isfinite(value)]
    changes = [(other - one) ** 2 for one, other in zip(values, values[1:])]
    return math.sqrt(sum(changes) / len(changes)) if changes else None


def _late(record: Record) -> float:
    """Return the share of the time in which an answer was overdue."""
    end = record.scenario.duration
    times = [0.0, *(time for time, _ in record.answers if 0.0 <= time <= end), end]
    gaps = [other - one for one, other in zip(times, times[1:])]
    return sum(gap for gap in gaps if gap > _LATE_S) / end


def _processor(record: Record) -> float:
    return record.busy / record.scenario.duration


def _leave(record: Record) -> float:
    """Return the time from the reachable set point until the input leaves its limit [s]."""
    rows = record.between(BACK_AT, math.inf)
    left = (row.time for row in rows if abs(row.input) < _LIMITED)
    return next(left, math.inf) - BACK_AT


def _recovery(record: Record) -> Optional[float]:
    """Return the longest time from an event until the speed stays in the settling band [s]."""
    events = [*record.scenario.events, record.scenario.duration]
    spans = [record.between(one, other) for one, other in zip(events, events[1:])]
    found = [
        _settled_after(rows, max(_BAND * abs(rows[0].set_point), _LEAST_BAND)) for rows in spans
    ]
    return max(found) if found else None


def _not_finite(record: Record) -> float:
    """Count the answers that are not finite without a recent NaN message."""
    wrong = [time for time, value in record.answers if not math.isfinite(value)]
    excused = [
        time
        for time in wrong
        if any(0.0 <= time - event <= _NAN_S for event in record.scenario.events)
    ]
    return float(len(wrong) - len(excused))


def _mean_input(record: Record, begin: float, end: float) -> float:
    values = [row.input for row in record.between(begin, end)]
    return sum(values) / len(values)


def _ramp(record: Record, begin: float, end: float) -> Optional[Line]:
    """Fit a line to the input while it is not limited."""
    points = [
        (row.time, row.input) for row in record.between(begin, end) if abs(row.input) < _LIMITED
    ]
    return fit_line(points)


def _set_point_response(record: Record) -> float:
    """Return the input's response to the set point [1/(rad/s)]."""
    after = _mean_input(record, ASKED_AT + 0.1, STANDSTILL_AT)
    return (after - _mean_input(record, 0.5 * ASKED_AT, ASKED_AT)) / LITTLE


def _output_response(record: Record) -> float:
    """Return the input's response to the motor [1/(rad/s)]; positive against the motor."""
    # The response to the set point continues meanwhile: an integral grows further.
    line = _ramp(record, ASKED_AT + 0.15, STANDSTILL_AT)
    last = record.rows[-1]
    expected = min(line.at(last.time), 1.0) if line else last.input
    if line is None:
        expected = _mean_input(record, ASKED_AT + 0.15, STANDSTILL_AT)
    return (expected - last.input) / (2.0 * LITTLE)


def _kick(record: Record) -> Optional[float]:
    """Return the peak of the input at a step above the line that follows [1/(rad/s)]."""
    line = _ramp(record, ASKED_AT + 0.15, STANDSTILL_AT)
    if line is None:
        return None
    rows = record.between(ASKED_AT, ASKED_AT + 0.1)
    return max(max((row.input - line.at(row.time)) / LITTLE for row in rows), 0.0)


def _standstill_answers(record: Record) -> Optional[float]:
    return None if record.standstill_rest is None else float(record.standstill_answers)


def _standstill_rest(record: Record) -> Optional[float]:
    return record.standstill_rest


def _standstill_jump(record: Record) -> Optional[float]:
    """Return the time by which the integral grew while the clock was paused [s]."""
    line = _ramp(record, ASKED_AT + 0.15, STANDSTILL_AT)
    has_stood = record.standstill_rest is not None
    if not has_stood or line is None or abs(line.slope) < _NO_GROWTH:
        return None
    rows = record.between(STANDSTILL_AT + 0.03, FASTER_AT)
    before = rows[0].time, rows[0].input
    return abs((before[1] - line.at(before[0])) / line.slope)


def _interval_error(record: Record) -> Optional[float]:
    """Return the relative change of the integral's growth at another loop rate."""
    quick = _ramp(record, 0.2, SLOW_AT)
    slow = _ramp(record, SLOW_AT + 2.0 * SLOW_STEP_S, math.inf)
    if quick is None or slow is None or abs(quick.slope) < _NO_GROWTH:
        return None
    return abs(slow.slope / quick.slope - 1.0)


METRICS: Dict[str, Metric] = {
    "set_point_response": Metric(
        "answer to the set point", "1/(rad/s)", _set_point_response, is_least=True
    ),
    "output_response": Metric("answer to the motor", "1/(rad/s)", _output_response, is_least=True),
    "kick": Metric("leap of the input at a step", "1/(rad/s)", _kick),
    "standstill_answers": Metric("answers while the clock stands", "", _standstill_answers),
    "standstill_rest": Metric("rest while the clock stands", "", _standstill_rest, is_least=True),
    "standstill_jump": Metric("time that passed meanwhile", "s", _standstill_jump),
    "processor": Metric("processor time for each second", "s", _processor),
    "interval_error": Metric("integral off at another rate", "", _interval_error),
    "rise_time": Metric("rise time", "s", lambda record: _worst(record, _rise)),
    "overshoot": Metric("overshoot", "%", lambda record: _worst(record, _overshoot)),
    "settling_time": Metric("settling time", "s", lambda record: _worst(record, _settling)),
    "steady_error": Metric("steady error", "rad/s", lambda record: _worst(record, _steady_error)),
    "absolute_error": Metric("integral of |error|", "rad", _absolute_error),
    "effort": Metric("integral of input squared", "s", _effort),
    "tracking_error": Metric("mean |error|", "rad/s", _tracking_error),
    "peak_input": Metric("largest |input|", "", _peak),
    "chatter": Metric("chatter of the input", "", _chatter),
    "late": Metric("share of time without answer", "", _late),
    "leave_time": Metric("time to leave the limit", "s", _leave),
    "recovery_time": Metric("time to recover", "s", _recovery),
    "not_finite": Metric("answers that are no numbers", "", _not_finite),
}

_HELD = ("set_point_response", "output_response", "kick")
_STANDSTILL = ("standstill_answers", "standstill_rest", "standstill_jump")
_STEPS = ("rise_time", "overshoot", "settling_time", "steady_error")
#: Metrics of each scenario.
SCENARIO_METRICS: Dict[str, Tuple[str, ...]] = {
    "held": (*_HELD, *_STANDSTILL, "late", "processor"),
    "rate": ("interval_error",),
    "steps": (*_STEPS, "absolute_error", "effort", "peak_input", "chatter", "late", "processor"),
    "ramp": ("tracking_error", "peak_input"),
    "sine": ("tracking_error", "peak_input"),
    "windup": ("leave_time", "recovery_time", "peak_input"),
    "noise": ("steady_error", "chatter", "peak_input"),
    "load": ("recovery_time", "steady_error", "peak_input"),
    "slower": ("overshoot", "settling_time", "steady_error", "peak_input"),
    "faster": ("overshoot", "settling_time", "steady_error", "chatter", "peak_input"),
    "missing": ("recovery_time", "peak_input"),
    "restart": ("recovery_time", "peak_input"),
    "early": ("recovery_time", "peak_input"),
    "nan": ("recovery_time", "not_finite", "peak_input"),
}


def metrics_of(record: Record) -> Dict[str, Optional[float]]:
    """Return the figures of a completed scenario, by name of the metric.

    :param record: record of the scenario
    """
    return {name: METRICS[name].of(record) for name in SCENARIO_METRICS[record.scenario.name]}
