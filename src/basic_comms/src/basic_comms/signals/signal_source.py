"""Signal source: computes samples from settings and time."""

from typing import NamedTuple

from basic_comms.signals.oscillator import PhaseAccumulator
from basic_comms.signals.shapes import SHAPES
from basic_comms.signals.signal_parameters import SignalParameters
from basic_comms.signals.sweeps import Chirp


class Sample(NamedTuple):
    """A sample of a signal, with its settings.

    :ivar value: the signal, including the offset
    :ivar amplitude: peak around the offset
    :ivar frequency: angular frequency [rad/s]; of a chirp the instantaneous one
    :ivar phase: phase of the oscillator, including the constant ``phase``, modulo whole turns [rad]
    """

    value: float
    amplitude: float
    frequency: float
    phase: float


class SignalSource:
    """Source of the samples of a signal whose settings may change at any sample.

    One oscillator runs through all waveforms. From one sample to the next its phase advances with
    the later sample's frequency, so no change of frequency, amplitude, waveform or sample rate
    makes it jump, and a sine is ``offset + amplitude * sin(frequency * time_x + phase)`` as long as
    its frequency has not been changed. Only ``phase`` shifts it, by exactly its change.

    ==================================  ===========================================================
    sine, square, triangle, sawtooth    ``offset +- amplitude``, by the phase
    pulse                               ``offset`` or ``offset + amplitude``, by the phase
    chirp                               a sine whose frequency sweeps, see :class:`.Chirp`
    constant                            ``offset + amplitude``
    step                                ``offset``, from ``step_time`` on ``offset + amplitude``
    ramp                                ``offset + slope * t`` until ``offset +- amplitude``
    gaussian_noise, uniform_noise       a new value with each sample, see :class:`.Noise`
    prbs                                ``offset +- amplitude``, see :class:`.Prbs`
    multisine                           scaled to ``offset +- amplitude``, see :class:`.Multisine`
    file                                scaled to ``offset +- amplitude``, see :class:`.Series`
    ==================================  ===========================================================

    The shapes with a start (chirp, step, ramp, noise, prbs, multisine, file) start at time 0, or at
    the sample with which they are selected later. Meanwhile the oscillator continues, with
    ``frequency`` or the chirp's frequency, so that a periodic shape keeps its phase.
    """

    def __init__(self) -> None:
        self._oscillator = PhaseAccumulator()
        self.reset()

    def reset(self) -> None:
        """Restart: phase 0 at time 0, and the waveform from its start."""
        self._oscillator.reset()
        self._waveform = ""
        self._time = 0.0

    def sample(self, time_x: float, settings: SignalParameters) -> Sample:
        """Return the next sample.

        :param time_x: time of the sample since the start of the signal, never decreasing [s]
        :param settings: settings of this sample
        :returns: the sample
        """
        if settings.waveform != self._waveform:
            self._shape = SHAPES[settings.waveform]()
            self._begun = time_x if self._waveform else 0.0
            self._waveform = settings.waveform
        elapsed = time_x - self._begun
        frequency = mean_frequency = settings.frequency
        if self._waveform == "chirp":
            chirp = Chirp(
                settings.chirp_f0,
                settings.chirp_f1,
                settings.chirp_duration,
                settings.chirp_shape == "logarithmic",
                settings.chirp_repeat,
            )
            frequency = chirp.frequency(elapsed)
            before = max(0.0, self._time - self._begun)
            mean_frequency = chirp.mean_frequency(before, elapsed)
        self._time = time_x
        phase = self._oscillator.advance(time_x, mean_frequency) + settings.phase
        amplitude = settings.amplitude
        value = settings.offset + amplitude * self._shape(phase, elapsed, settings)
        return Sample(value, amplitude, frequency, phase)
