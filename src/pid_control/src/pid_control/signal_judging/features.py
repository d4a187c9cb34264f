"""Features of a generated signal and a process node's output: rate, sine, gain, phase shift."""

import bisect
import math
from typing import List, NamedTuple, Optional, Sequence, Tuple

from pid_control.signal_judging.channels import Channel, oscillates
from pid_control.signal_judging.sine_fit import SineFit, fit_sine, is_constant, wrapped

#: Shapes of an output: a sine, its magnitude, or its positive half.
SINE, RECTIFIED, HALF = "sine", "rectified", "half-wave"
#: Distortion up to which a shape counts as rectified.
_SURE = 0.1
#: Distortion up to which an output without an input counts as a sine.
_GOES_ON = 0.3
#: Share of the end of such an output that must oscillate too: a buffer empties before.
_END = 0.25
#: Share of the largest value from which a sample of a half wave counts as positive.
_ABOVE = 0.02


class SignalFeatures(NamedTuple):
    """Features of a generator's signal.

    :ivar rate: messages per second
    :ivar sine: the sine; None without one
    """

    rate: Optional[float]
    sine: Optional[SineFit]


class ProcessFeatures(NamedTuple):
    """Features of a process node's output, relative to its input.

    :ivar rate: messages per second
    :ivar shape: SINE, RECTIFIED or HALF
    :ivar gain: amplitude of the output per amplitude of the input
    :ivar shifts: lead of the output over the input that it was computed from, from -pi to pi [rad]:
        by the latest message before the output, and by the previous one if both arrived together
    :ivar offset: mean of the sine
    :ivar lowest: least value
    :ivar distortion: RMS of the residual, as a share of the amplitude
    :ivar not_finite: number of values that are NaN or infinite
    """

    rate: Optional[float]
    shape: str
    gain: float
    shifts: Tuple[float, float]
    offset: float
    lowest: float
    distortion: float
    not_finite: int

    def shift_error(self, expected: float) -> float:
        """Return the distance of the phase shift from an expected one [rad].

        :param expected: expected phase shift, modulo pi for a rectified sine [rad]
        """
        turn = math.pi if self.shape == RECTIFIED else 2.0 * math.pi
        return min(abs(math.remainder(shift - expected, turn)) for shift in self.shifts)

    def shift_distance(self, other: "ProcessFeatures", move: float = 0.0) -> float:
        """Return the distance between the phase shifts of two records [rad].

        :param other: features of the other record
        :param move: expected difference [rad]
        """
        return min(self.shift_error(shift + move) for shift in other.shifts)


def signal_features(signal: Channel) -> SignalFeatures:
    """Return the features of a generator's signal."""
    finite = signal.finite()
    return SignalFeatures(signal.rate(), fit_sine(finite.times, finite.values))


def process_features(
    output: Channel, arrivals: Sequence[float], sine: SineFit
) -> Optional[ProcessFeatures]:
    """Return the features of a process node's output; None if it is constant.

    A loop answers with its last received value, at any time before the next message. So each output
    is compared with the input at the arrival of that message, not at its own time. A node that
    delays the signal is constant until its buffer is full: without a shape that fits, what is
    constant at first does not count if a period or more is left.

    :param output: the output
    :param arrivals: times of arrival of the inputs [s]
    :param sine: the input
    """
    finite = output.finite()
    latest = [_latest(arrivals, time, bisect.bisect_right) for time in finite.times]
    before = [_latest(arrivals, time, bisect.bisect_left) for time in finite.times]
    known = [index for index, time in enumerate(before) if time > -math.inf]
    if not known:
        return None
    values = [finite.values[index] for index in known]
    times = [latest[index] for index in known]
    first = _first_full(times, values, sine.frequency)
    times, values, known = times[first:], values[first:], known[first:]
    shape, fit = _shape(times, values, sine.frequency)
    if fit is None:
        return None
    other = _fit(shape, [before[index] for index in known], values, sine.frequency)
    shifts = tuple(wrapped(one.phase - sine.phase) for one in (fit, other or fit))
    return ProcessFeatures(
        output.rate(),
        shape,
        fit.amplitude / sine.amplitude,
        (shifts[0], shifts[1]),
        fit.offset,
        min(values),
        fit.distortion,
        len(output.values) - len(finite.values),
    )


def is_sine_like(output: Channel, frequency: float, begin: float, end: float) -> bool:
    """Return True if an output continues as a sine to the end, and does not just settle.

    A node that delays the signal still sends the rest of its buffer, which is part of a sine.

    :param output: the output
    :param frequency: angular frequency of the sine [rad/s]
    :param begin: begin of the record, at least one period before its end [s]
    :param end: end of the record [s]
    """
    finite = output.between(begin, end).finite()
    last = finite.between(end - _END * (end - begin)).values
    if not oscillates(finite) or not last:
        return False
    shape, fit = _shape(finite.times, finite.values, frequency)
    if is_constant(last) and shape != HALF:
        return False
    return fit is not None and fit.distortion <= _GOES_ON


def _latest(arrivals: Sequence[float], time: float, bisect_of: object) -> float:
    index = bisect_of(arrivals, time)  # type: ignore[operator]
    return arrivals[index - 1] if index > 0 else -math.inf


def _first_full(times: Sequence[float], values: Sequence[float], frequency: float) -> int:
    """Return the index of the first value from a full buffer; 0 if no such start is seen."""
    fit = _shape(times, values, frequency)[1]
    if fit is None or fit.distortion <= _SURE:
        return 0
    first = next((index for index, value in enumerate(values) if value != values[0]), 0)
    rest = _shape(times[first:], values[first:], frequency)[1]
    is_whole = times[-1] - times[first] >= 2.0 * math.pi / frequency
    return first if is_whole and rest is not None and rest.distortion <= _SURE else 0


def _shape(
    times: Sequence[float], values: Sequence[float], frequency: float
) -> Tuple[str, Optional[SineFit]]:
    """Return the shape that fits best, a sine unless another shape clearly fits better."""
    sine = _fit(SINE, times, values, frequency)
    if sine is not None and sine.distortion <= _SURE:
        return SINE, sine
    for shape in (RECTIFIED, HALF):
        fit = _fit(shape, times, values, frequency)
        if fit is not None and fit.distortion <= _SURE:
            return shape, fit
    return SINE, sine


def _fit(
    shape: str, times: Sequence[float], values: Sequence[float], frequency: float
) -> Optional[SineFit]:
    if shape == SINE:
        return fit_sine(times, values, frequency)
    if shape == HALF:
        return _half_wave(times, values, frequency)
    return _rectified(times, values, frequency)


def _rectified(
    times: Sequence[float], values: Sequence[float], frequency: float
) -> Optional[SineFit]:
    """Fit the magnitude of a sine without offset, plus an offset.

    The square of the sine has twice the frequency: a^2 sin^2 x = a^2 (1 - cos 2x) / 2. The offset
    is the least value, where the magnitude is nearly 0 because of sampling; so it is refined once.
    """
    offset = min(values)
    squares: Optional[SineFit] = None
    for _ in range(2):
        squares = fit_sine(times, [(value - offset) ** 2 for value in values], 2.0 * frequency)
        if squares is None:
            return None
        amplitude = math.sqrt(2.0 * squares.amplitude)
        # -cos 2x = sin(2x - pi/2)
        phase = 0.5 * (squares.phase + 0.5 * math.pi)
        shape = [amplitude * abs(math.sin(frequency * time + phase)) for time in times]
        offset = sum(value - one for value, one in zip(values, shape)) / len(values)
    assert squares is not None
    errors = [value - offset - one for value, one in zip(values, shape)]
    distortion = math.sqrt(sum(error**2 for error in errors) / len(errors)) / amplitude
    return squares._replace(
        amplitude=amplitude,
        frequency=frequency,
        phase=phase,
        offset=offset,
        distortion=distortion,
    )


def _half_wave(
    times: Sequence[float], values: Sequence[float], frequency: float
) -> Optional[SineFit]:
    """Fit a sine to the samples above 0; all others must be 0, with the sine below 0."""
    least = _ABOVE * max(values)
    above = [index for index, value in enumerate(values) if value > least]
    others = [index for index, value in enumerate(values) if value <= least]
    if not others or any(values[index] < -least for index in others):
        return None
    fit = fit_sine([times[one] for one in above], [values[one] for one in above], frequency)
    if fit is None:
        return None
    errors: List[float] = []
    for time, value in zip(times, values):
        errors.append(value - max(0.0, fit.at(time)))
    distortion = math.sqrt(sum(error**2 for error in errors) / len(errors)) / fit.amplitude
    return fit._replace(distortion=distortion)
