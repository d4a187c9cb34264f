"""Parameters of the signal generator, and rules between them."""

import math
from typing import Any, Optional

from basic_comms.signals.replay import Series, SeriesError, load_series
from nodekit import (
    BoolParameter,
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    ParameterError,
    ParameterSet,
    RateParameter,
    StringParameter,
    read_once,
    rule,
)

#: Names of all waveforms, the basic ones first.
WAVEFORMS = (
    "sine",
    "square",
    "triangle",
    "sawtooth",
    "constant",
    "step",
    "ramp",
    "pulse",
    "chirp",
    "gaussian_noise",
    "uniform_noise",
    "prbs",
    "multisine",
    "file",
)

_TWO_PI = 2.0 * math.pi

#: Largest magnitudes; their sums still fit into a float32.
_MAX_VALUE, _MAX_FREQUENCY, _MAX_SECONDS = 1e9, 1e6, 1e9


class SeriesPath(str):
    """Path of a CSV file, with the content of the file.

    :ivar series: the signal in the file; None for an empty path
    """

    series: Optional[Series] = None


class SeriesParameter(StringParameter):
    """Path of a CSV file of time,value; the file is read when the path is set."""

    @property
    def allowed(self) -> str:
        return "the path of a CSV file of time,value or empty text"

    def coerce(self, raw: Any) -> SeriesPath:
        if isinstance(raw, SeriesPath):
            return raw
        path = SeriesPath(super().coerce(raw))
        if path:
            try:
                path.series = load_series(path)
            except SeriesError as error:
                raise ParameterError(self.name, raw, self.allowed, str(error)) from None
        return path


def _frequency(default: float, help: str) -> FloatParameter:
    return FloatParameter(
        default, minimum=-_MAX_FREQUENCY, maximum=_MAX_FREQUENCY, unit="rad/s", help=help
    )


def _value(default: float, help: str) -> FloatParameter:
    return FloatParameter(default, minimum=-_MAX_VALUE, maximum=_MAX_VALUE, help=help)


class SignalParameters(ParameterSet):
    """Shape and run time of a signal; all parameters may change at any sample."""

    rate = RateParameter(10.0, help="samples published per second")
    waveform = EnumParameter("sine", choices=WAVEFORMS, help="shape of the signal")
    amplitude = FloatParameter(
        2.0, minimum=0.0, maximum=_MAX_VALUE, help="peak of the signal around its offset"
    )
    frequency = _frequency(
        _TWO_PI, "angular frequency; 0 holds the signal, a negative one runs it backwards"
    )
    phase = FloatParameter(
        0.0, minimum=-1e6, maximum=1e6, unit="rad", help="added to the phase of the signal"
    )
    offset = _value(0.0, "added to the signal")

    duty = FloatParameter(
        0.5, above=0.0, below=1.0, help="square, pulse: part of the period that is high"
    )
    symmetry = FloatParameter(
        1.0, minimum=0.0, maximum=1.0, help="sawtooth: part of the period that rises"
    )
    step_time = FloatParameter(
        1.0, minimum=0.0, maximum=_MAX_SECONDS, unit="s", help="step: time of the step"
    )
    slope = FloatParameter(
        1.0,
        minimum=-_MAX_VALUE,
        maximum=_MAX_VALUE,
        unit="1/s",
        help="ramp: rise per second, until the amplitude is reached",
    )
    chirp_f0 = _frequency(_TWO_PI * 0.1, "chirp: angular frequency at its start")
    chirp_f1 = _frequency(_TWO_PI, "chirp: angular frequency at its end")
    chirp_duration = FloatParameter(
        10.0, above=0.0, maximum=_MAX_SECONDS, unit="s", help="chirp: time from start to end"
    )
    chirp_shape = EnumParameter(
        "linear", choices=("linear", "logarithmic"), help="chirp: how the frequency sweeps"
    )
    chirp_repeat = BoolParameter(
        False, help="chirp: start again at its end, instead of staying at the last frequency"
    )
    seed = IntParameter(0, minimum=0, help="noise, prbs: seed of the sequence")
    prbs_order = IntParameter(
        7, minimum=2, maximum=31, help="prbs: length n of the register; the period is 2^n - 1 chips"
    )
    chip_time = FloatParameter(
        0.1, minimum=1e-4, maximum=_MAX_SECONDS, unit="s", help="prbs: duration of a chip"
    )
    multisine_amplitudes = ListParameter(
        [1.0, 0.5],
        element=FloatParameter(0.0, minimum=-_MAX_VALUE, maximum=_MAX_VALUE, help="relative"),
        min_length=1,
        help="multisine: amplitudes relative to each other; their sum reaches the amplitude",
    )
    multisine_frequencies = ListParameter(
        [_TWO_PI, 2.0 * _TWO_PI],
        element=_frequency(0.0, "one for each component"),
        min_length=1,
        unit="rad/s",
        help="multisine: angular frequencies",
    )
    multisine_phases = ListParameter(
        [0.0, 0.0],
        element=FloatParameter(0.0, minimum=-1e6, maximum=1e6, help="one for each component"),
        min_length=1,
        unit="rad",
        help="multisine: phases",
    )
    file = SeriesParameter(
        "",
        help="file: path of a CSV file of time,value; its largest magnitude reaches the amplitude",
    )
    file_mode = EnumParameter(
        "linear", choices=("linear", "hold"), help="file: values between two rows"
    )
    file_loop = BoolParameter(False, help="file: start again at its end, instead of staying there")

    start_delay = FloatParameter(
        0.0, minimum=0.0, maximum=_MAX_SECONDS, unit="s", help="time before the signal starts"
    )
    duration = FloatParameter(
        0.0,
        minimum=0.0,
        maximum=_MAX_SECONDS,
        unit="s",
        help="duration of the signal; 0 for unlimited",
    )
    stop_value = _value(0.0, "value published while the signal does not run")
    autostart = read_once(BoolParameter(True, help="run from the start, without a call of ~enable"))

    @property
    def series(self) -> Optional[Series]:
        """The signal read from ``file``; None if it is empty."""
        path = self.file
        return path.series if isinstance(path, SeriesPath) else None

    @property
    def highest_frequency(self) -> float:
        """Highest fundamental frequency of the signal, >= 0 [rad/s]; 0 without one.

        At a sample rate in Hz the signal is aliased if this exceeds ``pi * rate``, the Nyquist
        limit. A PRBS is aliased if its chips are shorter than the interval between samples.
        """
        if self.waveform in ("sine", "square", "triangle", "sawtooth", "pulse"):
            return abs(self.frequency)
        if self.waveform == "chirp":
            return max(abs(self.chirp_f0), abs(self.chirp_f1))
        if self.waveform == "multisine":
            return max(abs(frequency) for frequency in self.multisine_frequencies)
        if self.waveform == "prbs":
            return math.pi / self.chip_time
        return 0.0

    @property
    def aliasing(self) -> str:
        """Why the signal is aliased, as text; empty if it is not."""
        nyquist = math.pi * self.rate
        if self.highest_frequency <= nyquist:
            return ""
        return (
            f"{self.highest_frequency:.6g} rad/s is above the Nyquist frequency of {nyquist:.6g}"
            f" rad/s at a rate of {self.rate:g} Hz"
        )

    @rule("chirp_shape", "chirp_f0", "chirp_f1")
    def _logarithmic_chirp(self) -> None:
        ends = (self.chirp_f0, self.chirp_f1)
        if self.chirp_shape == "logarithmic" and (min(ends) <= 0.0 or ends[0] == ends[1]):
            raise ValueError("a logarithmic chirp must have two frequencies above 0 that differ")

    @rule("multisine_amplitudes", "multisine_frequencies", "multisine_phases")
    def _components(self) -> None:
        lists = (self.multisine_amplitudes, self.multisine_frequencies, self.multisine_phases)
        if len(set(map(len, lists))) > 1:
            raise ValueError("the three lists must have one length")
        if not any(self.multisine_amplitudes):
            raise ValueError("at least one amplitude must be other than 0")

    @rule("waveform", "file")
    def _file_to_replay(self) -> None:
        if self.waveform == "file" and not self.file:
            raise ValueError("waveform 'file' must have a CSV file of time,value")
