"""What follows from the settings of a signal."""

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from basic_comms.signals.signal_parameters import SignalParameters


def highest_frequency(settings: "SignalParameters") -> float:
    """Return the highest fundamental frequency of the signal, for a comparison with Nyquist.

    At a sample rate ``rate`` in Hz a signal is misrepresented if this exceeds ``pi * rate``. For a
    PRBS that is the case when its chips are shorter than the interval between samples.

    :param settings: settings of the signal
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
