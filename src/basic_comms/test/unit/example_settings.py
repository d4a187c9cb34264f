"""A complete set of signal settings for tests, and the range of each for hypothesis."""

import math

from hypothesis import strategies as st

from basic_comms.signals.replay import Series
from basic_comms.signals.signal_parameters import WAVEFORMS, SeriesPath, SignalParameters

FILE = SeriesPath("example.csv")
FILE.series = Series([0.0, 1.0, 3.0], [0.0, -4.0, 8.0])

DEFAULTS = {
    **SignalParameters().as_dict(),
    "waveform": "sine",
    "amplitude": 2.0,
    "frequency": 2.0 * math.pi,
    "phase": 0.0,
    "offset": 0.0,
    "duty": 0.5,
    "symmetry": 1.0,
    "step_time": 1.0,
    "slope": 1.0,
    "chirp_f0": 1.0,
    "chirp_f1": 50.0,
    "chirp_duration": 10.0,
    "chirp_shape": "linear",
    "chirp_repeat": False,
    "seed": 0,
    "prbs_order": 9,
    "chip_time": 0.1,
    "multisine_amplitudes": [1.0, 0.5, 0.25],
    "multisine_frequencies": [1.0, 5.0, 25.0],
    "multisine_phases": [0.0, 2.0, -1.0],
    "file": FILE,
    "file_mode": "linear",
    "file_loop": False,
}


def settings(**changes):
    """Return the default settings with some changes."""
    assert set(changes) <= set(DEFAULTS)
    return SignalParameters.from_coerced({**DEFAULTS, **changes})


values = st.floats(-1e6, 1e6)
positive_frequencies = st.floats(1e-3, 1e4)


def any_settings(waveforms=WAVEFORMS):
    """Return a strategy for valid settings of any waveform."""
    return st.builds(
        lambda components, **single: settings(
            multisine_amplitudes=[component[0] for component in components],
            multisine_frequencies=[component[1] for component in components],
            multisine_phases=[component[2] for component in components],
            **single,
        ),
        components=st.lists(
            st.tuples(st.floats(0.0, 1e3), st.floats(-1e4, 1e4), values), min_size=1, max_size=4
        ),
        waveform=st.sampled_from(waveforms),
        amplitude=st.floats(0.0, 1e6),
        frequency=st.floats(-1e4, 1e4),
        phase=values,
        offset=values,
        duty=st.floats(0.0, 1.0, exclude_min=True, exclude_max=True),
        symmetry=st.floats(0.0, 1.0),
        step_time=st.floats(0.0, 1e6),
        slope=values,
        chirp_f0=positive_frequencies,
        chirp_f1=positive_frequencies.map(lambda frequency: frequency + 1e4),
        chirp_duration=st.floats(1e-3, 1e4),
        chirp_shape=st.sampled_from(["linear", "logarithmic"]),
        chirp_repeat=st.booleans(),
        seed=st.integers(0, 2**31 - 1),
        prbs_order=st.integers(2, 31),
        chip_time=st.floats(1e-6, 1e3),
        file_mode=st.sampled_from(["linear", "hold"]),
        file_loop=st.booleans(),
    )
