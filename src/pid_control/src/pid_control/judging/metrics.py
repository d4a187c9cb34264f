"""Metrics of a controller, computed from the records of its scenarios."""

import math
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from pid_control.judging.line_fit import Line, fit_line
from pid_control.judging.probes import best_fit, is_ignored
from pid_control.judging.record import Record, Row
from pid_control.judging.scenarios import RATE_PARTS, SLOW_STEP_S, STAYS

#: Share of a limit from which the input counts as limited.
_LIMITED = 0.99
#: The input at which the motor reaches its greatest speed.
_FULL = 1.0
#: Settling band around a set point: share of the step, and its least width [rad/s].
_BAND, _LEAST_BAND = 0.05, 0.1
#: Duration of the end of a step, where the speed should be steady [s].
_END_S = 0.2
#: Longest interval of answers that are not late [s]: the loop's rate is 100 Hz.
_LATE_S = 0.025
#: Time after a step of the error, or a pause of the clock, in which the growth is not measured [s].
_AFTER_STEP_S, _AFTER_PAUSE_S = 0.04, 0.06
#: Growth rate of the input below which there is no integral [1/s].
_NO_GROWTH = 1e-4
#: Share of the input's variance that a steady growth has to explain.
_STEADY = 0.98
#: Relative difference of growths, or of times, that are equal.
_EQUAL = 0.2
#: Smallest change of speed that counts as a step, for an overshoot [share of the step].
_MOVED = 0.02
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


def _overshoot(rows: List[Row], height: float) -> Optional[float]:
    """Return the overshoot [% of the step]; None if the motor did not move."""
    speeds = [row.speed for row in rows]
    if max(speeds) - min(speeds) < _MOVED * abs(height):
        return None
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


def leave_times(record: Record) -> List[float]:
    """Return the time from each reachable set point until the input leaves its limit [s].

    The limit is the input at the end of the unreachable set point, at most the motor's own.
    """
    found = []
    for _, end, sign in STAYS:
        rows = record.between(end, _next_step(record, end))
        limit = min(sign * rows[0].input, _FULL)
        left = (row.time for row in rows if sign * row.input < _LIMITED * limit)
        found.append(0.0 if limit <= 0.0 else next(left, math.inf) - end)
    return found


def _leave(record: Record) -> float:
    return max(leave_times(record))


def _recovery(record: Record) -> Optional[float]:
    """Return the longest time from an event until the speed stays in the settling band [s]."""
    events = record.scenario.events
    found = []
    for begin, end in zip(events, [*events[1:], math.inf]):
        rows = record.between(begin, min(end, _next_step(record, begin)))
        found.append(_settled_after(rows, max(_BAND * abs(rows[0].set_point), _LEAST_BAND)))
    return max(found) if found else None


def _next_step(record: Record, begin: float) -> float:
    """Return the time of the next step of the set point [s]."""
    return next((start for start, _, _ in _windows(record) if start > begin), math.inf)


def _not_finite(record: Record) -> float:
    """Count the answers that are not finite without a recent NaN message."""
    wrong = [time for time, value in record.answers if not math.isfinite(value)]
    excused = [
        time
        for time in wrong
        if any(0.0 <= time - event <= _NAN_S for event in record.scenario.events)
    ]
    return float(len(wrong) - len(excused))


def _set_point_response(record: Record) -> Optional[float]:
    return _response(record, is_output=False)


def _output_response(record: Record) -> Optional[float]:
    return _response(record, is_output=True)


def _response(record: Record, is_output: bool) -> Optional[float]:
    """Return the smaller of the responses of both signs; 0 without a response [1/(rad/s)].

    None if no linear law explains the response, as for an input in steps, or always at its limit.
    """
    if is_ignored(record.answers, is_output):
        # At a limit, even a controller that depends on the error gives the same answer.
        return None if _is_always_limited(record) else 0.0
    fit = best_fit(record.answers, is_output)
    return None if fit is None else min(fit.response())


def _is_always_limited(record: Record) -> bool:
    values = [abs(value) for _, value in record.answers]
    return bool(values) and min(values) >= _LIMITED


def _kick(record: Record) -> Optional[float]:
    """Return the peak of the input at a step above its later value [1/(rad/s)]."""
    fit = best_fit(record.answers, is_output=False)
    return None if fit is None else fit.leap


def _standstill_answers(record: Record) -> Optional[float]:
    return float(record.pauses[-1].answers) if record.pauses else None


def _standstill_rest(record: Record) -> Optional[float]:
    return record.pauses[-1].rest if record.pauses else None


def _line(record: Record, begin: float, end: float) -> Optional[Line]:
    """Fit a line to the answers; None if they do not grow steadily, as at a limit."""
    points = _points(record, begin, end)
    line = fit_line(points)
    if line is None:
        return None
    mean = sum(value for _, value in points) / len(points)
    total = sum((value - mean) ** 2 for _, value in points)
    rest = sum((value - line.at(time)) ** 2 for time, value in points)
    return line if total > 0.0 and rest <= (1.0 - _STEADY) * total else None


def _standstill_jump(record: Record) -> Optional[float]:
    """Return the time by which the integral grew while the clock was paused [s].

    None if it did not grow in proportion to the pauses: then it does not use the machine's clock.
    """
    leaps, slopes = [], []
    for pause, (begin, _, sign) in zip(record.pauses, RATE_PARTS):
        points = _points(record, begin + _AFTER_STEP_S, pause.time)
        line = fit_line(points)
        after = _points(record, pause.time + 0.02, pause.time + _AFTER_PAUSE_S)
        if line is None or not after or line.slope == 0.0:
            return None
        leaps.append(sign * sum(value - line.at(time) for time, value in after) / len(after))
        slopes.append(sign * line.slope)
    if len(leaps) < 2 or abs(slopes[0]) < _NO_GROWTH:
        return None
    jumps = [leap / slope for leap, slope in zip(leaps, slopes)]
    if max(abs(jump) for jump in jumps) < _AFTER_STEP_S:
        return max(abs(jump) for jump in jumps)
    ratio = record.pauses[1].length / record.pauses[0].length
    return min(jumps) if abs(leaps[1] - ratio * leaps[0]) < _EQUAL * abs(leaps[1]) else None


def _points(record: Record, begin: float, end: float) -> List[Tuple[float, float]]:
    return [
        (time, value)
        for time, value in record.answers
        if begin <= time < end and math.isfinite(value)
    ]


def growths(record: Record) -> Optional[Tuple[float, float]]:
    """Return the integral's growth in the quick and in the slow loop [1/s].

    None if unknown: the input does not grow steadily, or the growth differs once the loop is quick
    again.
    """
    found = []
    for begin, end, sign in RATE_PARTS:
        is_slow = record.scenario.slow[0] <= begin < record.scenario.slow[1]
        after = 2.0 * SLOW_STEP_S if is_slow else _AFTER_STEP_S
        pause = min((one for one in record.scenario.pauses if begin < one < end), default=end)
        line = _line(record, begin + after, pause)
        if line is None:
            return None
        found.append(line.slope * sign)
    quick, slow, again = (0.5 * (found[i] + found[i + 1]) for i in (0, 2, 4))
    is_same = abs(again - quick) <= _EQUAL * abs(quick)
    return (quick, slow) if is_same and quick != 0.0 else None


def _interval_error(record: Record) -> Optional[float]:
    """Return the relative change of the integral's growth at another loop rate."""
    found = growths(record)
    return None if found is None else abs(found[1] / found[0] - 1.0)


METRICS: Dict[str, Metric] = {
    "set_point_response": Metric(
        "answer to the set point", "1/(rad/s)", _set_point_response, is_least=True
    ),
    "output_response": Metric("answer to the motor", "1/(rad/s)", _output_response, is_least=True),
    "kick": Metric("jump of the input at a step", "1/(rad/s)", _kick),
    "standstill_answers": Metric("answers while the clock is paused", "", _standstill_answers),
    "standstill_rest": Metric(
        "idle share while the clock is paused", "", _standstill_rest, is_least=True
    ),
    "standstill_jump": Metric("integrated time during pauses", "s", _standstill_jump),
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
    "not_finite": Metric("answers that are not finite", "", _not_finite),
}

_HELD = ("set_point_response", "output_response", "kick")
_STANDSTILL = ("standstill_answers", "standstill_rest")
_STEPS = ("rise_time", "overshoot", "settling_time", "steady_error")
#: Metrics of each scenario.
SCENARIO_METRICS: Dict[str, Tuple[str, ...]] = {
    "held": (*_HELD, *_STANDSTILL, "late", "processor"),
    "rate": ("standstill_jump", "interval_error"),
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
