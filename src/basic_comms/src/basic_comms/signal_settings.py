"""The settings of a signal: what they are called, and which of them fit together."""

import math
from typing import Optional, Protocol, Sequence

from basic_comms.replay import Series


class SignalSettings(Protocol):
    """What a signal source reads for each sample. Any object with these attributes will do.

    Frequencies are angular. The output lies within ``offset`` +- ``amplitude`` for every waveform.
    """

    waveform: str
    amplitude: float  #: peak around the offset, >= 0
    frequency: float  #: rad/s; 0 holds the phase, negative runs it backwards
    phase: float  #: constant added to the phase, rad
    offset: float
    duty: float  #: square, pulse: high part of the period, in (0, 1)
    symmetry: float  #: sawtooth: rising part of the period, in [0, 1]
    step_time: float  #: step: s after its start
    slope: float  #: ramp: 1/s, until the amplitude is reached
    chirp_f0: float  #: rad/s at the start of a sweep
    chirp_f1: float  #: rad/s at its end
    chirp_duration: float  #: s, > 0
    chirp_shape: str  #: linear or logarithmic
    chirp_repeat: bool
    seed: int  #: gaussian_noise, uniform_noise, prbs
    prbs_order: int  #: 2 to 31
    chip_time: float  #: prbs: s, > 0
    multisine_amplitudes: Sequence[float]  #: relative to each other
    multisine_frequencies: Sequence[float]  #: rad/s
    multisine_phases: Sequence[float]  #: rad
    series: Optional[Series]  #: what ``load_series(file)`` gave; None without a file
    file_mode: str  #: linear or hold
    file_loop: bool


def conflict(settings: SignalSettings) -> Optional[str]:
    """Tell what does not fit together, whichever waveform is chosen at the moment.

    :param settings: settings, each within its own range
    :returns: a sentence that says what is allowed, or None
    """
    first, last = settings.chirp_f0, settings.chirp_f1
    if settings.chirp_shape == "logarithmic" and (first <= 0.0 or last <= 0.0 or first == last):
        return (
            f"chirp_f0 {first!r} and chirp_f1 {last!r}: a logarithmic chirp needs two positive "
            "frequencies that differ"
        )
    lengths = [
        len(settings.multisine_amplitudes),
        len(settings.multisine_frequencies),
        len(settings.multisine_phases),
    ]
    if len(set(lengths)) > 1:
        return (
            "multisine_amplitudes, multisine_frequencies and multisine_phases have "
            f"{lengths[0]}, {lengths[1]} and {lengths[2]} items: lists of one length are allowed"
        )
    if settings.waveform == "file" and settings.series is None:
        return "waveform 'file': a CSV file of time,value is needed in the parameter file"
    return None


def highest_frequency(settings: SignalSettings) -> float:
    """Return the highest fundamental frequency of the signal, for a comparison with Nyquist.

    At a sample rate ``rate`` in Hz a signal is misrepresented if this exceeds ``pi * rate``. For a
    PRBS that is the case when its chips are shorter than the interval between samples.

    :param settings: settings that fit together
    :returns: angular frequency, rad/s, >= 0; 0 for a signal without one
    """
    if settings.waveform in ("sine", "square", "triangle", "sawtooth", "pulse"):
        return abs(settings.frequency)
    if settings.waveform == "chirp":
        return max(abs(settings.chirp_f0), abs(settings.chirp_f1))
    if settings.waveform == "multisine":
        return max((abs(frequency) for frequency in settings.multisine_frequencies), default=0.0)
    if settings.waveform == "prbs":
        return math.pi / settings.chip_time
    return 0.0
