"""Test errors for a controller while the motor is held, and the law fitted to its answers."""

import math
from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

#: Error of each probe [rad/s]: the smallest reaches no limit with any gain, the largest shows any
#: dependence; each error is made by the set point first, then by the motor.
AMPLITUDES = (0.001, 0.01, 0.1, 1.0, 10.0)
#: Start of the first probe, and duration of a probe with the rest after it [s].
FIRST_AT, PROBE_S = 0.2, 0.5
#: Corners of the error of a probe: time in the probe [s], and sign. The integral ends at 0.
_SIGNS = ((0.0, 1.0), (0.1, -1.0), (0.3, 1.0), (0.4, 0.0))
#: Times at which an error begins and ends to be constant [s].
_PARTS = ((0.0, 0.1), (0.1, 0.3), (0.3, 0.4))
#: Time after a step in which a derivative, or its filter, may act [s].
_STEP_S = 0.04
#: Longest delay of an answer that is searched for [s].
_LONGEST_DELAY_S = 0.06
#: Share of the answer's variance that a linear law has to explain.
_EXPLAINED = 0.98
#: Change of the input that does not count: inputs are float32.
_NO_CHANGE = 1e-6

#: Fewest answers to a probe, relative difference of equal answers, and least period [s].
_FEWEST, _EQUAL, _LEAST_PERIOD_S = 12, 0.1, 1e-3

Answers = Sequence[Tuple[float, float]]


class ProbeFit(NamedTuple):
    """Linear law u = c + gain e + growth integral(e) that explains the answers to a probe.

    :ivar amplitude: error of the probe [rad/s]
    :ivar gain: the proportional answer [1/(rad/s)]
    :ivar growth: the integral's answer [1/rad]
    :ivar gain_below: the proportional answer to an error below 0, else as ``gain``
    :ivar growth_below: the integral's answer to an error below 0
    :ivar delay: time from an error to the answer [s]
    :ivar leap: jump at a step beyond the linear answer [1/(rad/s)]
    :ivar explained: explained share of the variance
    """

    amplitude: float
    gain: float
    growth: float
    gain_below: float
    growth_below: float
    delay: float
    leap: float
    explained: float

    def response(self) -> Tuple[float, float]:
        """Return the answers to errors above and below 0 [1/(rad/s)]."""
        time = _PARTS[0][1]
        return self.gain + time * self.growth, self.gain_below + time * self.growth_below


def corners(sign: float, is_output: bool) -> List[Tuple[float, float]]:
    """Return the corners of the set point, or of the held motor.

    :param sign: sign of the signal for a positive error
    :param is_output: True for the motor
    """
    found = [(0.0, 0.0)]
    for index, amplitude in enumerate(AMPLITUDES):
        begin = begin_of(index, is_output)
        for time, value in _SIGNS:
            moment = round(begin + time, 9)  # as times in a scenario are
            found += [(moment, found[-1][1]), (moment, sign * value * amplitude)]
    return found


def begin_of(index: int, is_output: bool) -> float:
    """Return the start of a probe [s].

    :param index: index of its amplitude
    :param is_output: True if the motor makes the error
    """
    return round(FIRST_AT + PROBE_S * (2 * index + is_output), 9)


#: End of the last probe [s].
END_AT = begin_of(len(AMPLITUDES), False)


def first_change(answers: Answers) -> float:
    """Return the time of the first input that differs from the one at the start [s]; inf without.

    :param answers: time [s] and input of each answer
    """
    start = answers[0][1] if answers else 0.0
    return next((time for time, value in answers if abs(value - start) > _NO_CHANGE), math.inf)


def is_constant(answers: Answers, is_output: bool) -> bool:
    """Return True if the input is the same in all probes of a topic.

    :param answers: time [s] and input of each answer
    :param is_output: True for the motor's probes
    """
    probes = _probes(answers, is_output)
    return all(probe and max(probe) - min(probe) <= _NO_CHANGE for probe in probes)


def is_ignored(answers: Answers, is_output: bool) -> bool:
    """Return True if the input is the same in all probes of a topic, although it changes in others.

    It is True also if the input never changes. It is False if the input first changes after the
    topic's last probe, as that of a controller that starts late, or is as large or small in them as
    anywhere: it may be at a limit.

    :param answers: time [s] and input of each answer
    :param is_output: True for the motor's probes
    """
    if not is_constant(answers, is_output):
        return False
    first = first_change(answers)
    if first == math.inf:
        return True
    least, largest = (pick(value for _, value in answers) for pick in (min, max))
    return first < begin_of(len(AMPLITUDES) - 1, is_output) and all(
        least + _NO_CHANGE < value < largest - _NO_CHANGE
        for probe in _probes(answers, is_output)
        for value in probe
    )


def _probes(answers: Answers, is_output: bool) -> List[List[float]]:
    begins = [begin_of(index, is_output) for index in range(len(AMPLITUDES))]
    return [
        [value for time, value in answers if begin <= time < begin + PROBE_S] for begin in begins
    ]


def best_fit(answers: Answers, is_output: bool) -> Optional[ProbeFit]:
    """Return the linear law that explains the answers to two probes of a topic; None without one.

    The answer to a single probe may be linear by chance: a switching controller has a gain at each
    amplitude, but a different one.

    :param answers: time [s] and input of each answer
    :param is_output: True for the motor's probes
    """
    before: Optional[ProbeFit] = None
    for index, amplitude in enumerate(AMPLITUDES):
        begin = begin_of(index, is_output)
        mine = [
            (round(time - begin, 9), value)
            for time, value in answers
            if begin - PROBE_S / 5.0 <= time < begin + _SIGNS[-1][0]
        ]
        fit = _fit_of(mine, amplitude)
        if before is not None and fit is not None and _are_equal(before, fit):
            return before
        before = fit
    return None


def _are_equal(one: ProbeFit, other: ProbeFit) -> bool:
    pairs = zip(one.response(), other.response())
    return all(abs(a - b) <= _EQUAL * max(abs(a), abs(b)) for a, b in pairs)


def _fit_of(answers: Answers, amplitude: float) -> Optional[ProbeFit]:
    """Return the law for the answers to a probe; a one-sided law only if no other fits."""
    if len(answers) < _FEWEST:
        return None
    times = np.array([time for time, _ in answers])
    values = np.array([value for _, value in answers])
    if not np.isfinite(values).all() or values.max() - values.min() <= _NO_CHANGE * amplitude:
        return None
    period = float(np.median(np.diff(times)))
    errors = amplitude * np.array([_sign(time) for time in times])
    is_kept = np.array([_is_late_in_part(time) for time in times])
    lags = range(int(_LONGEST_DELAY_S / max(period, _LEAST_PERIOD_S)) + 1)
    for is_one_sided in (False, True):
        fits = []
        for lag in lags:
            seen = np.concatenate([np.zeros(lag), errors[: len(errors) - lag]])
            fit = _fit(times, values, seen, errors, is_kept, amplitude, is_one_sided)
            fits.append(fit._replace(delay=lag * period))
        best = max(fits, key=lambda fit: fit.explained)
        if best.explained >= _EXPLAINED:
            return best
    return None


def _sign(time: float) -> float:
    reached = [value for corner, value in _SIGNS if corner <= time + 1e-6]
    return reached[-1] if reached else 0.0


def _is_late_in_part(time: float) -> bool:
    return any(begin + _STEP_S <= time < end for begin, end in _PARTS)


def _fit(
    times: np.ndarray,
    values: np.ndarray,
    seen: np.ndarray,
    errors: np.ndarray,
    is_kept: np.ndarray,
    amplitude: float,
    is_one_sided: bool,
) -> ProbeFit:
    intervals = np.diff(times, prepend=times[0])
    matrix = _columns(seen, intervals, is_one_sided)
    kept = values[is_kept]
    solution = np.linalg.lstsq(matrix[is_kept], kept, rcond=None)[0]
    residual = kept - matrix[is_kept] @ solution
    total = float(((kept - kept.mean()) ** 2).sum())
    explained = 1.0 - float((residual**2).sum()) / total if total > 0.0 else 0.0
    count = 1 + is_one_sided
    gains, growths = solution[1 : 1 + count], solution[1 + count :]
    period = float(np.median(intervals))
    # Without the delay: an answer that comes earlier than others is no jump beyond the law.
    rest = values - _columns(errors, intervals, is_one_sided) @ solution
    leaps = [
        float(np.sign(step) * rest[near][np.argmax(np.sign(step) * rest[near])]) / abs(step)
        for step, near in _steps(times, amplitude)
        if near.any()
    ]
    # What the integral grows in an iteration, or in the delay, is not a jump.
    lag = float(np.abs(np.cumsum((errors - seen) * intervals)).max()) / amplitude
    grown = (1.5 * period + lag) * float(np.abs(growths).max())
    leap = min(leaps) - grown if leaps else 0.0
    return ProbeFit(
        amplitude,
        float(gains[0]),
        float(growths[0]),
        float(gains[-1]),
        float(growths[-1]),
        0.0,
        max(leap, 0.0),
        explained,
    )


def _columns(seen: np.ndarray, intervals: np.ndarray, is_one_sided: bool) -> np.ndarray:
    """Return the terms of the law over time: constant, errors of each side, and their integrals."""
    sides = [np.maximum(seen, 0.0), np.minimum(seen, 0.0)] if is_one_sided else [seen]
    columns = [np.ones(len(seen)), *sides, *(np.cumsum(side * intervals) for side in sides)]
    return np.stack(columns, axis=1)


def _steps(times: np.ndarray, amplitude: float) -> List[Tuple[float, np.ndarray]]:
    """Return the height of each step of the error, and the answers just after it."""
    before, found = 0.0, []
    for corner, value in _SIGNS[:-1]:
        near = (times >= corner - 1e-6) & (times < corner + _STEP_S)
        found.append((amplitude * (value - before), near))
        before = value
    return found
