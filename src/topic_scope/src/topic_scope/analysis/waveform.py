"""Choice of step or wave measurements for a trace, and the phase between two traces.

A trace that rests at one level, moves to another and rests there is a step; a periodic trace is a
wave. Any other trace has none of these measurements.
"""

import math
from typing import Dict, NamedTuple, Optional, Tuple

import numpy

from topic_scope.analysis import steps, waves
from topic_scope.analysis.crossings import longest_stretch
from topic_scope.analysis.measurement import Measurement, measured, unmeasurable
from topic_scope.analysis.periods import STANDS, frequency
from topic_scope.analysis.ring import Samples

#: Names of the measurements of steps and waves.
SHAPES = ("rise", "overshoot", "settling", "duty", "cycle_mean", "cycle_rms")
_NO_CYCLES = unmeasurable("a step has no periods")
#: Least fraction of a trace's power in the sine for a phase.
_SINE = 0.5


def measure_waveform(
    times: numpy.ndarray,
    values: numpy.ndarray,
    longest: float = math.inf,
    shapes: bool = True,
    hertz: Optional[Measurement] = None,
) -> Dict[str, Measurement]:
    """Measure a step or a wave.

    :param times: ascending [s]
    :param values: the samples; non-finite values are ignored
    :param longest: a gap is longer than this [s]
    :param shapes: whether to measure more than the frequency
    :param hertz: the frequency, if already known
    :returns: frequency in Hz, and of the longest stretch that has no gap rise time (rise) and
        settling time (settling) in s, overshoot and duty in %, mean (cycle_mean) and RMS
        (cycle_rms) over whole periods
    """
    times, values, largest = _scaled(times, values)
    if hertz is None:
        hertz = frequency(times, values, longest)
    found = _shapes(times, values, longest, hertz) if shapes else {}
    for name in ("cycle_mean", "cycle_rms"):
        if name in found:
            found[name] = found[name].times(largest)
    return {"frequency": hertz, **found}


def phase(samples: Samples, reference: Samples, longest: float = math.inf) -> Measurement:
    """Return the phase lead of a trace over a reference, at the frequency of the reference.

    :param samples: times in s, ascending, and values of the trace
    :param reference: times in s, ascending, and values of the reference
    :param longest: longest time between connected samples of the reference [s]
    :returns: above -180 and up to 180 [degrees]
    """
    (times, values, _), (others, turns, _) = _scaled(*samples), _scaled(*reference)
    if len(times) < 3 or len(others) < 3:
        return unmeasurable("too few samples")
    hertz = frequency(others, turns, longest)
    if hertz.value is None:
        return unmeasurable(f"the reference has no frequency: {hertz.reason}")
    # Same start and whole periods for both: a partial period would add an error.
    begin, end = max(times[0], others[0]), min(times[-1], others[-1])
    end = begin + math.floor((end - begin) * hertz.value + 1e-6) / hertz.value
    one, other = (_sine(*part, hertz, begin, end) for part in ((times, values), (others, turns)))
    if one is None or other is None:
        return unmeasurable("no component at the frequency of the reference")
    turned = math.degrees(one.angle - other.angle)
    # A frequency error rotates both equally, about the middles of their samples.
    apart = 360.0 * hertz.uncertainty * abs(one.middle - other.middle)
    return measured(180.0 - (180.0 - turned) % 360.0, one.doubt + other.doubt + apart)


def _shapes(
    times: numpy.ndarray, values: numpy.ndarray, longest: float, hertz: Measurement
) -> Dict[str, Measurement]:
    part = longest_stretch(times, longest)
    times, values = times[part], values[part]
    if len(values) < 2 or not values.min() < values.max():
        return dict.fromkeys(SHAPES, STANDS)
    step = steps.step_of(times, values)
    if isinstance(step, steps.Step):
        return {
            "rise": steps.rise(step),
            "overshoot": steps.overshoot(step),
            "settling": steps.settling(step),
            "duty": unmeasurable("a step has no duty cycle"),
            "cycle_mean": _NO_CYCLES,
            "cycle_rms": _NO_CYCLES,
        }
    wave = waves.wave_of(times, values, hertz) if hertz.value is not None else None
    if wave is None:
        why = hertz.reason or "no whole period without a gap"
        return dict.fromkeys(SHAPES, unmeasurable(f"no step: {step}; no wave: {why}"))
    mean, rms = waves.cycle_figures(times, values, wave, hertz)
    return {
        "rise": waves.rise(wave),
        "overshoot": waves.overshoot(wave),
        "settling": unmeasurable("a wave does not settle"),
        "duty": waves.duty(wave),
        "cycle_mean": mean,
        "cycle_rms": rms,
    }


def _scaled(
    times: numpy.ndarray, values: numpy.ndarray
) -> Tuple[numpy.ndarray, numpy.ndarray, float]:
    """Return the finite samples scaled to -1 to 1, so that no difference or sum overflows.

    :returns: their times [s]; their values relative to the largest; and the largest
    """
    finite = numpy.isfinite(values)
    if not finite.all():
        times, values = times[finite], values[finite]
    largest = float(numpy.abs(values).max(initial=0.0))
    return times, values / largest if largest else values, largest


class _Sine(NamedTuple):
    """Least-squares sine of a trace.

    :param angle: phase at the start [rad]
    :param doubt: uncertainty of the phase [degrees]
    :param middle: mean of the sample times [s]
    """

    angle: float
    doubt: float
    middle: float


def _sine(
    times: numpy.ndarray, values: numpy.ndarray, frequency: Measurement, begin: float, end: float
) -> Optional[_Sine]:
    """Return the least-squares sine of a trace; None if it has none."""
    assert frequency.value is not None
    inside = (times >= begin) & (times <= end)
    times, parts = times[inside], values[inside]
    if len(parts) < 4 or not parts.min() < parts.max():
        return None
    turns = 2.0 * math.pi * frequency.value * (times - begin)
    parts = (parts - parts.mean()) / (parts.max() - parts.min())
    columns = numpy.array([numpy.cos(turns), numpy.sin(turns), numpy.ones(len(turns))])
    try:
        fitted = numpy.linalg.solve(columns @ columns.T, columns @ parts)
    except numpy.linalg.LinAlgError:
        return None
    cosine, sine, _ = fitted
    rest = float(numpy.square(parts - fitted @ columns).mean())
    share = rest / float(parts.var())
    if not share < 1.0 - _SINE:
        return None
    # Contributions of noise, and of edges between two samples.
    noise = 3.0 * math.sqrt(2.0 * rest / len(parts)) / math.hypot(cosine, sine)
    edges = math.pi * math.sqrt(share) * float(numpy.median(numpy.diff(times))) * frequency.value
    return _Sine(math.atan2(cosine, sine), math.degrees(noise + edges), float(times.mean()))
