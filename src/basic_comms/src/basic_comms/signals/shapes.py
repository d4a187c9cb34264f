"""Waveforms by name: each computes a value in [-1, 1] from the settings."""

import math
from typing import Callable, Dict, Optional, Tuple

from basic_comms.signals import waveforms
from basic_comms.signals.multisine import Multisine
from basic_comms.signals.noise import Noise
from basic_comms.signals.prbs import Prbs
from basic_comms.signals.signal_parameters import SignalParameters

#: (phase in rad, time since the waveform was chosen in s, settings) -> value in [-1, 1]
Shape = Callable[[float, float, SignalParameters], float]


def _sine(phase: float, elapsed: float, settings: SignalParameters) -> float:
    return waveforms.sine(phase)


def _square(phase: float, elapsed: float, settings: SignalParameters) -> float:
    return waveforms.square(phase, settings.duty)


def _pulse(phase: float, elapsed: float, settings: SignalParameters) -> float:
    return waveforms.pulse(phase, settings.duty)


def _triangle(phase: float, elapsed: float, settings: SignalParameters) -> float:
    return waveforms.triangle(phase)


def _sawtooth(phase: float, elapsed: float, settings: SignalParameters) -> float:
    return waveforms.sawtooth(phase, settings.symmetry)


def _constant(phase: float, elapsed: float, settings: SignalParameters) -> float:
    return 1.0


def _step(phase: float, elapsed: float, settings: SignalParameters) -> float:
    return waveforms.step(elapsed, settings.step_time)


def _ramp(phase: float, elapsed: float, settings: SignalParameters) -> float:
    return waveforms.ramp(elapsed, settings.slope, settings.amplitude)


def _file(phase: float, elapsed: float, settings: SignalParameters) -> float:
    if settings.series is None:
        return 0.0
    return settings.series.value(elapsed, settings.file_mode == "hold", settings.file_loop)


def _multisine() -> Shape:
    multisine = Multisine()

    def shape(phase: float, elapsed: float, settings: SignalParameters) -> float:
        return multisine.value(
            elapsed,
            settings.multisine_amplitudes,
            settings.multisine_frequencies,
            settings.multisine_phases,
        )

    return shape


class _NoiseShape:
    """White noise that restarts its sequence when the seed changes."""

    def __init__(self, draw: Callable[[Noise], float]) -> None:
        self._draw = draw
        self._seed: Optional[int] = None

    def __call__(self, phase: float, elapsed: float, settings: SignalParameters) -> float:
        if settings.seed != self._seed:
            self._seed = settings.seed
            self._noise = Noise(settings.seed)
        return self._draw(self._noise)


class _PrbsShape:
    """PRBS whose chips continue without a jump when their duration changes."""

    def __init__(self) -> None:
        self._register: Optional[Tuple[int, int]] = None
        self._elapsed = self._chips = 0.0
        self._anchor = self._anchor_chips = 0.0
        self._chip_time = 0.0

    def __call__(self, phase: float, elapsed: float, settings: SignalParameters) -> float:
        register = (settings.prbs_order, settings.seed)
        if register != self._register:
            self._register = register
            self._prbs = Prbs(*register)
        if settings.chip_time != self._chip_time:
            self._chip_time = settings.chip_time
            self._anchor, self._anchor_chips = self._elapsed, self._chips
        self._elapsed = elapsed
        self._chips = self._anchor_chips + (elapsed - self._anchor) / self._chip_time
        return float(self._prbs.chip(math.floor(self._chips + waveforms.EDGE)))


#: For each waveform, a function that creates a new one.
SHAPES: Dict[str, Callable[[], Shape]] = {
    "sine": lambda: _sine,
    "square": lambda: _square,
    "triangle": lambda: _triangle,
    "sawtooth": lambda: _sawtooth,
    "constant": lambda: _constant,
    "step": lambda: _step,
    "ramp": lambda: _ramp,
    "pulse": lambda: _pulse,
    "chirp": lambda: _sine,
    "gaussian_noise": lambda: _NoiseShape(Noise.gaussian),
    "uniform_noise": lambda: _NoiseShape(Noise.uniform),
    "prbs": _PrbsShape,
    "multisine": _multisine,
    "file": lambda: _file,
}
