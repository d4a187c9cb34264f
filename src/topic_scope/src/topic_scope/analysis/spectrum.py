"""The spectrum of a trace: the amplitude of the sine at each frequency."""

import math
from typing import Dict, List, NamedTuple, Optional, Tuple

import numpy

from topic_scope.analysis.crossings import longest_stretch

#: Windows by name: the amplitudes of their cosines, and how far a peak reaches, lines.
WINDOWS: Dict[str, Tuple[Tuple[float, ...], int]] = {
    "hann": ((0.5, 0.5), 2),
    "flattop": ((0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368), 5),
    "blackman": ((0.42, 0.5, 0.08), 3),
    "rectangular": ((1.0,), 1),
}
#: Most samples that are used, the latest ones.
LONGEST = 1 << 17
#: Least number of samples of a part, so that there is a spectrum of it.
_LEAST = 8
#: Samples that are off even times by more than this part of their distance are put there.
_UNEVEN = 1e-3
#: Samples are bunched where their distances differ by more than this factor.
_BUNCHED = 10.0
#: A peak is this much above the middle of all lines, and this part of the largest one at least.
_ABOVE, _SMALLEST = 10.0, 1e-3
#: Up to this line, or as far as the window reaches, a peak is mixed with its mirror image.
_LOWEST = 3
#: The lines of a peak differ from those of one sine by less than this part of the largest one, and
#: so many times the middle of all lines.
_SHAPE, _ABOVE_NOISE = 0.1, 5.0
#: Why a peak is not measured.
TOO_FEW = "too few periods or samples of one"
NOT_SINGLE = "not a single line: several sines, or one that changes"
#: How well the frequency of a peak is known, lines.
SURE = 0.5


class Spectrum(NamedTuple):
    """A spectrum.

    :param step: from one line to the next [Hz]; the first is at 0 Hz
    :param amplitudes: of the sine at each line, in the unit of the trace
    :param seconds: how long the samples are that it is made of [s]
    """

    step: float
    amplitudes: numpy.ndarray
    seconds: float


class Peak(NamedTuple):
    """A sine in a spectrum.

    :param frequency: Hz
    :param amplitude: in the unit of the trace
    :param uncertainty: how far off the frequency may be [Hz]; None where frequency and amplitude
        cannot be measured
    :param reason: why they cannot, in words
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
    """Return the spectrum of the longest stretch of a trace that has no gap, less its mean.

    :param times: ascending [s]
    :param values: the samples; what is not finite is left out
    :param window: one of :data:`WINDOWS`
    :param averages: of how many parts the mean power is taken; each overlaps half of the next
    :param longest: a gap is longer than this [s]
    :returns: None where too few samples
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
    """Return the largest peaks, the largest first.

    :param found: the spectrum
    :param window: the window that it was made with
    :param most: how many at most
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
            # At the other end, half of the rate, there is a mirror image, too.
            is_clear = lowest < frequency / found.step < len(lines) - 1 - lowest
            reason = "" if is_clear else TOO_FEW
            if is_clear and not _is_single(found, frequency, amplitude, window):
                reason = NOT_SINGLE
            sure = None if reason else SURE * found.step
            result.append(Peak(frequency, amplitude, sure, reason))
    return result


def reduced(found: Spectrum, most: int) -> Tuple[float, float, numpy.ndarray]:
    """Return a spectrum in fewer points, without losing a peak.

    :param found: the spectrum
    :param most: how many points there may be
    :returns: frequency of the first point, from one to the next [Hz], and the greatest amplitude at
        each
    """
    many = -(-len(found.amplitudes) // most)
    starts = numpy.arange(0, len(found.amplitudes), many)
    greatest = numpy.maximum.reduceat(found.amplitudes, starts)
    return (many - 1) / 2 * found.step, many * found.step, greatest


def _stretch(
    times: numpy.ndarray, values: numpy.ndarray, longest: float
) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Return the longest part of a trace without a gap, and no two samples of one time."""
    used = numpy.isfinite(values)
    used[1:] &= numpy.diff(times) > 0.0
    times, values = times[used], values[used]
    part = longest_stretch(times, longest)
    return times[part][-LONGEST:], values[part][-LONGEST:]


def _evenly(times: numpy.ndarray, values: numpy.ndarray) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Return as many samples at even times, on a smooth line through those that there are."""
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
    # Beside the straight line, so that both ends have the slope of their neighbours.
    slopes = numpy.gradient(values, times)
    rise = (values[after] - values[before]) / widths[before]
    bend = (slopes[before] - rise) * rest - (slopes[after] - rise) * part
    bend[_bunched(widths)[before]] = 0.0
    straight = values[before] * rest + values[after] * part
    return even, straight + widths[before] * part * rest * bend


def _bunched(widths: numpy.ndarray) -> numpy.ndarray:
    """Return the samples between which a line is straight, as the times do not define its slope."""
    beside = numpy.concatenate([widths[:1], widths, widths[-1:]])
    three = numpy.array([beside[:-2], widths, beside[2:]])
    bunched: numpy.ndarray = three.max(axis=0) > _BUNCHED * three.min(axis=0)
    return bunched


def _top(found: Spectrum, index: int, window: str) -> Tuple[float, float]:
    """Return the sine that a line and its neighbours come from."""
    # The top of the parabola through three lines on a scale of dB says where it is.
    low, top, high = numpy.log(numpy.maximum(found.amplitudes[index - 1 : index + 2], 1e-300))
    bend = low - 2.0 * top + high
    aside = (low - high) / (2.0 * bend) if bend < 0.0 else 0.0
    others = WINDOWS[window][0][1:]
    if not others:  # it is no parabola: two lines beside a sine are as one to the other distance
        aside = math.copysign(1.0 / (1.0 + math.exp(top - max(low, high))), high - low)
    left = float(_left(numpy.array([aside]), window)[0])
    return float((index + aside) * found.step), float(numpy.exp(top) / left)


def _left(aside: numpy.ndarray, window: str) -> numpy.ndarray:
    """Return which part a window leaves of a sine that lies so far beside a line [lines]."""
    (mean, *others), _ = WINDOWS[window]
    left = mean * numpy.sinc(aside)
    for k, part in enumerate(others, 1):
        left += part / 2.0 * (numpy.sinc(aside - k) + numpy.sinc(aside + k))
    return numpy.asarray(left / mean)


def _is_single(found: Spectrum, frequency: float, amplitude: float, window: str) -> bool:
    """Return whether a peak has the shape that the window gives to one sine."""
    place, reach = frequency / found.step, WINDOWS[window][1]
    around = numpy.arange(int(round(place)) - reach, int(round(place)) + reach + 1)
    around = around[(around > 0) & (around < len(found.amplitudes))]
    lines = found.amplitudes[around]
    expected = amplitude * numpy.abs(_left(around - place, window))
    noise = float(numpy.median(found.amplitudes))
    allowed = _SHAPE * float(lines.max()) + _ABOVE_NOISE * noise
    return bool(numpy.abs(lines - expected).max() <= allowed)
