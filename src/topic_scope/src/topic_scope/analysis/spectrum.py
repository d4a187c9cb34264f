"""Amplitude spectrum of a trace, and its peaks."""

import math
from typing import Dict, List, NamedTuple, Optional, Tuple

import numpy

from topic_scope.analysis.crossings import longest_stretch

#: Windows by name: the amplitudes of their cosines, and the half-width of a peak [lines].
WINDOWS: Dict[str, Tuple[Tuple[float, ...], int]] = {
    "hann": ((0.5, 0.5), 2),
    "flattop": ((0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368), 5),
    "blackman": ((0.42, 0.5, 0.08), 3),
    "rectangular": ((1.0,), 1),
}
#: Most samples that are used: the latest.
LONGEST = 1 << 17
#: Least number of samples of a part.
_LEAST = 8
#: Samples are resampled if they deviate from even times by more than this part of their spacing.
_UNEVEN = 1e-3
#: Samples are bunched if their spacings differ by more than this factor.
_BUNCHED = 10.0
#: A peak exceeds the median line by this factor, and is at least this part of the largest line.
_ABOVE, _SMALLEST = 10.0, 1e-3
#: Below this line, or within the window's half-width, a peak overlaps its mirror image.
_LOWEST = 3
#: The lines of a peak differ from those of a single sine by less than this part of the largest,
#: or this many times the median line.
_SHAPE, _ABOVE_NOISE = 0.1, 5.0
#: Reasons for peaks without a measurement.
TOO_FEW = "too few periods, or samples per period"
NOT_SINGLE = "not a single line: several sines, or a changing sine"
#: Uncertainty of a peak's frequency [lines].
SURE = 0.5


class Spectrum(NamedTuple):
    """Amplitude spectrum.

    :param step: spacing of the lines [Hz]; the first is at 0 Hz
    :param amplitudes: of the sine at each line, in the unit of the trace
    :param seconds: duration of the samples [s]
    """

    step: float
    amplitudes: numpy.ndarray
    seconds: float


class Peak(NamedTuple):
    """Peak of a spectrum.

    :param frequency: Hz
    :param amplitude: in the unit of the trace
    :param uncertainty: bound of the frequency's error [Hz]; None if frequency and amplitude
        cannot be measured
    :param reason: why they cannot be measured
    """

    frequency: float
    amplitude: float
    uncertainty: Optional[float]
    reason: str = ""


def spectrum(
    times: numpy.ndarray,
    values: numpy.ndarray,
    window: str = "hann",
    averages: int = 1,
    longest: float = numpy.inf,
) -> Optional[Spectrum]:
    """Return the spectrum of the longest gapless stretch of a trace, without its mean.

    :param times: ascending [s]
    :param values: the samples; non-finite values are ignored
    :param window: one of :data:`WINDOWS`
    :param averages: number of parts whose power is averaged; each overlaps half of the next
    :param longest: a gap is longer than this [s]
    :returns: None if there are too few samples
    """
    times, values = _evenly(*_stretch(times, values, longest))
    length = 2 * (len(values) // (averages + 1))
    if length < _LEAST or not times[0] < times[-1]:
        return None
    scale = float(numpy.abs(values).max()) or 1.0
    cosines, _ = WINDOWS[window]
    turns = 2 * numpy.pi * numpy.arange(length) / length
    weights = sum((-1) ** k * part * numpy.cos(k * turns) for k, part in enumerate(cosines))
    power = numpy.zeros(length // 2 + 1)
    for index in range(averages):
        part = values[index * length // 2 :][:length] / scale
        power += numpy.abs(numpy.fft.rfft((part - part.mean()) * weights)) ** 2
    amplitudes = numpy.sqrt(power / averages) * 2.0 * (scale / float(numpy.sum(weights)))
    rate = (len(times) - 1) / float(times[-1] - times[0])
    return Spectrum(rate / length, amplitudes, len(times) / rate)


def peaks(found: Spectrum, window: str, most: int = 5) -> List[Peak]:
    """Return the largest peaks in descending order.

    :param found: the spectrum
    :param window: the window that it was made with
    :param most: maximum number of peaks
    """
    lines = found.amplitudes
    reach = WINDOWS[window][1]
    least = max(_ABOVE * float(numpy.median(lines)), _SMALLEST * float(lines.max()))
    is_top = (lines[1:-1] > lines[:-2]) & (lines[1:-1] >= lines[2:]) & (lines[1:-1] >= least)
    tall = numpy.flatnonzero(is_top) + 1
    lowest = max(_LOWEST, reach)
    result: List[Peak] = []
    for index in sorted(tall, key=lambda one: -lines[one]):
        near = lines[max(index - reach, 0) : index + reach + 1]
        if len(result) == most or lines[index] == 0.0:
            break
        if lines[index] >= near.max():
            frequency, amplitude = _top(found, int(index), window)
            # There is a mirror image at half of the sampling rate, too.
            is_clear = lowest < frequency / found.step < len(lines) - 1 - lowest
            reason = "" if is_clear else TOO_FEW
            if is_clear and not _is_single(found, frequency, amplitude, window):
                reason = NOT_SINGLE
            sure = None if reason else SURE * found.step
            result.append(Peak(frequency, amplitude, sure, reason))
    return result


def reduced(found: Spectrum, most: int) -> Tuple[float, float, numpy.ndarray]:
    """Return a spectrum reduced to fewer points, without losing a peak.

    :param found: the spectrum
    :param most: maximum number of points
    :returns: frequency of the first point and spacing of the points [Hz], and the peak amplitude
        at each
    """
    many = -(-len(found.amplitudes) // most)
    starts = numpy.arange(0, len(found.amplitudes), many)
    greatest = numpy.maximum.reduceat(found.amplitudes, starts)
    return (many - 1) / 2 * found.step, many * found.step, greatest


def _stretch(
    times: numpy.ndarray, values: numpy.ndarray, longest: float
) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Return the longest gapless part of a trace, without duplicate times."""
    used = numpy.isfinite(values)
    used[1:] &= numpy.diff(times) > 0.0
    times, values = times[used], values[used]
    part = longest_stretch(times, longest)
    return times[part][-LONGEST:], values[part][-LONGEST:]


def _evenly(times: numpy.ndarray, values: numpy.ndarray) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Return the same number of samples at even times, interpolated smoothly."""
    if len(times) < _LEAST:
        return times, values
    even = numpy.linspace(times[0], times[-1], len(times))
    step = even[1] - even[0]
    if numpy.abs(times - even).max() <= _UNEVEN * step:
        return even, values
    widths = numpy.diff(times)
    after = numpy.clip(numpy.searchsorted(times, even, "right"), 1, len(times) - 1)
    before = after - 1
    part = (even - times[before]) / widths[before]
    rest = 1.0 - part
    # Relative to the straight line, so that both ends have the slope of their neighbours.
    slopes = numpy.gradient(values, times)
    rise = (values[after] - values[before]) / widths[before]
    bend = (slopes[before] - rise) * rest - (slopes[after] - rise) * part
    bend[_bunched(widths)[before]] = 0.0
    straight = values[before] * rest + values[after] * part
    return even, straight + widths[before] * part * rest * bend


def _bunched(widths: numpy.ndarray) -> numpy.ndarray:
    """Return the samples to connect linearly, because bunched times do not define a slope."""
    beside = numpy.concatenate([widths[:1], widths, widths[-1:]])
    three = numpy.array([beside[:-2], widths, beside[2:]])
    bunched: numpy.ndarray = three.max(axis=0) > _BUNCHED * three.min(axis=0)
    return bunched


def _top(found: Spectrum, index: int, window: str) -> Tuple[float, float]:
    """Return frequency and amplitude of the sine that causes a line and its neighbours."""
    # Its frequency is at the vertex of the parabola through three lines in dB.
    low, top, high = numpy.log(numpy.maximum(found.amplitudes[index - 1 : index + 2], 1e-300))
    bend = low - 2.0 * top + high
    aside = (low - high) / (2.0 * bend) if bend < 0.0 else 0.0
    others = WINDOWS[window][0][1:]
    if not others:  # a rectangular window: the amplitudes of two lines are inverse to the distances
        aside = math.copysign(1.0 / (1.0 + math.exp(top - max(low, high))), high - low)
    left = float(_left(numpy.array([aside]), window)[0])
    return float((index + aside) * found.step), float(numpy.exp(top) / left)


def _left(aside: numpy.ndarray, window: str) -> numpy.ndarray:
    """Return the gain of a window for a sine at this distance from a line [lines]."""
    (mean, *others), _ = WINDOWS[window]
    left = mean * numpy.sinc(aside)
    for k, part in enumerate(others, 1):
        left += part / 2.0 * (numpy.sinc(aside - k) + numpy.sinc(aside + k))
    return numpy.asarray(left / mean)


def _is_single(found: Spectrum, frequency: float, amplitude: float, window: str) -> bool:
    """Return whether a peak has the shape of a single sine under the window."""
    place, reach = frequency / found.step, WINDOWS[window][1]
    around = numpy.arange(int(round(place)) - reach, int(round(place)) + reach + 1)
    around = around[(around > 0) & (around < len(found.amplitudes))]
    lines = found.amplitudes[around]
    expected = amplitude * numpy.abs(_left(around - place, window))
    noise = float(numpy.median(found.amplitudes))
    allowed = _SHAPE * float(lines.max()) + _ABOVE_NOISE * noise
    return bool(numpy.abs(lines - expected).max() <= allowed)
