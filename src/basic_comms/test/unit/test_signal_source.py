"""Signal source: bounds, continuity and the effect of each setting."""

import math

import pytest
from example_settings import DEFAULTS, any_settings, settings
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from basic_comms.signals.noise import Noise
from basic_comms.signals.prbs import Prbs
from basic_comms.signals.shapes import SHAPES
from basic_comms.signals.signal_parameters import WAVEFORMS
from basic_comms.signals.signal_source import SignalSource
from basic_comms.signals.waveforms import TWO_PI

intervals = st.floats(0.0, 10.0)


def run(times, **changes):
    """Return the values of a signal with constant settings."""
    source, chosen = SignalSource(), settings(**changes)
    return [source.sample(time, chosen).value for time in times]


def distance(one, other):
    """Return the distance of two phases on the circle [rad]."""
    return abs(math.remainder(one - other, TWO_PI))


@given(st.lists(st.tuples(intervals, any_settings()), min_size=1, max_size=10))
def test_every_output_is_finite_and_within_the_amplitude_around_the_offset(steps):
    source, time = SignalSource(), 0.0
    for interval, chosen in steps:
        time += interval
        value, amplitude, frequency, phase = source.sample(time, chosen)
        assert chosen.offset - chosen.amplitude <= value <= chosen.offset + chosen.amplitude
        assert amplitude == chosen.amplitude
        assert math.isfinite(frequency) and math.isfinite(phase)


@given(st.lists(st.tuples(st.floats(0.0, 1e-3), any_settings()), min_size=2, max_size=10))
def test_no_change_but_that_of_phase_makes_the_phase_jump(steps):
    source, time, before = SignalSource(), 0.0, 0.0
    for interval, chosen in steps:
        sample = source.sample(time + interval, chosen)
        phase = sample.phase - chosen.phase
        if chosen.waveform == "chirp":
            # A chirp moves on by the mean of its frequency, which lies between its ends.
            highest = max(chosen.chirp_f0, chosen.chirp_f1)
            assert distance(phase, before) <= highest * (time + interval - time) + 1e-9
        else:
            advance = chosen.frequency * (time + interval - time)
            assert distance(phase, before + advance) < 1e-9
        time += interval
        before = phase


@given(st.floats(-1e3, 1e3), st.floats(-10.0, 10.0), st.lists(intervals, max_size=20))
def test_with_constant_settings_a_sine_is_that_of_frequency_times_time(frequency, phase, steps):
    source, chosen, time = SignalSource(), settings(frequency=frequency, phase=phase), 0.0
    for interval in steps:
        time += interval
        expected = 2.0 * math.sin(frequency * time + phase)
        assert source.sample(time, chosen).value == pytest.approx(expected, abs=1e-10)


def test_changes_of_amplitude_waveform_and_rate_keep_phase():
    source = SignalSource()
    source.sample(0.1, settings(amplitude=5.0))
    source.sample(0.2, settings(waveform="constant"))
    source.sample(0.201, settings(waveform="gaussian_noise"))
    source.sample(0.3, settings(waveform="square"))
    assert source.sample(0.55, settings()).value == pytest.approx(
        2.0 * math.sin(TWO_PI * 0.55), abs=1e-12
    )


def test_a_change_of_frequency_takes_effect_at_its_sample():
    source = SignalSource()
    source.sample(1.0, settings(frequency=1.0))
    sample = source.sample(1.5, settings(frequency=3.0))
    assert sample.phase == pytest.approx(1.0 + 3.0 * 0.5)
    assert sample.frequency == 3.0


@pytest.mark.parametrize(
    "waveform, reference",
    [
        ("sine", math.sin),
        ("square", lambda phase: signal.square(phase, 0.3)),
        ("pulse", lambda phase: (signal.square(phase, 0.3) + 1.0) / 2.0),
        ("triangle", lambda phase: signal.sawtooth(phase + math.pi / 2.0, 0.5)),
        ("sawtooth", lambda phase: signal.sawtooth(phase, 0.7)),
    ],
)
def test_periodic_shapes_scale_with_amplitude_offset_phase_and_their_own_setting(
    waveform, reference
):
    times = [n * 0.0317 for n in range(200)]
    chosen = {"amplitude": 3.0, "offset": 1.5, "phase": 0.4, "frequency": -5.0}
    values = run(times, waveform=waveform, duty=0.3, symmetry=0.7, **chosen)
    assert values == pytest.approx([1.5 + 3.0 * reference(0.4 - 5.0 * time) for time in times])


def test_shapes_of_time():
    times = [0.0, 0.5, 1.0, 5.0]
    assert run(times, waveform="constant", offset=1.0) == [3.0] * 4
    assert run(times, waveform="step", offset=1.0) == [1.0, 1.0, 3.0, 3.0]
    assert run(times, waveform="ramp", offset=1.0, slope=-1.5) == [1.0, 0.25, -0.5, -1.0]
    assert run(times, waveform="file") == pytest.approx([0.0, -0.5, -1.0, 2.0])
    assert run(times, waveform="file", file_mode="hold") == pytest.approx([0.0, 0.0, -1.0, 2.0])
    assert run(times, waveform="file", file_loop=True)[3] == pytest.approx(0.5)
    assert run(times, waveform="file", file="") == [0.0] * 4


def test_chirp_sweeps_from_time_zero_before_first_sample():
    late, whole = SignalSource(), SignalSource()
    chosen = settings(waveform="chirp")
    whole.sample(0.0, chosen)
    phase = late.sample(0.5, chosen).phase
    assert phase == pytest.approx(whole.sample(0.5, chosen).phase)
    assert phase == pytest.approx(1.0 * 0.5 + 4.9 * 0.5**2 / 2.0)


@pytest.mark.parametrize("shape", ["linear", "logarithmic"])
def test_chirp_equals_scipy_and_carries_its_instantaneous_frequency(shape):
    source, chosen = SignalSource(), settings(waveform="chirp", chirp_shape=shape, phase=0.5)
    for n in range(1001):
        time = n * 0.01
        sample = source.sample(time, chosen)
        degrees = math.degrees(0.5) - 90.0
        expected = signal.chirp(time, 1.0 / TWO_PI, 10.0, 50.0 / TWO_PI, shape, degrees)
        assert sample.value == pytest.approx(2.0 * expected, abs=1e-9)
    assert sample.frequency == pytest.approx(50.0)


def test_a_repeated_chirp_starts_again_at_its_first_frequency():
    source, chosen = SignalSource(), settings(waveform="chirp", chirp_repeat=True)
    assert source.sample(9.999999, chosen).frequency == pytest.approx(50.0, rel=1e-6)
    assert source.sample(10.0, chosen).frequency == 1.0


@pytest.mark.parametrize(
    "waveform", ["step", "ramp", "chirp", "uniform_noise", "prbs", "multisine", "file"]
)
def test_shapes_with_start_begin_at_selecting_sample(waveform):
    times = [n * 0.05 for n in range(100)]
    source, late = SignalSource(), []
    source.sample(7.0, settings(frequency=0.0))
    for time in times:
        late.append(source.sample(8.0 + time, settings(waveform=waveform, chirp_f0=0.0)).value)
    assert late == pytest.approx(run(times, waveform=waveform, chirp_f0=0.0), abs=1e-9)


@pytest.mark.parametrize("waveform", ["uniform_noise", "gaussian_noise", "prbs"])
def test_random_shapes_repeat_with_their_seed(waveform):
    times = [n * 0.1 for n in range(200)]
    assert run(times, waveform=waveform) == run(times, waveform=waveform)
    assert run(times, waveform=waveform) != run(times, waveform=waveform, seed=1)
    source = SignalSource()
    first = [source.sample(time, settings(waveform=waveform)).value for time in times]
    source.reset()
    assert [source.sample(time, settings(waveform=waveform)).value for time in times] == first


def test_change_of_seed_or_order_takes_effect_immediately():
    source = SignalSource()
    for n, seed in enumerate([3, 4, 4]):
        value = source.sample(n * 0.1, settings(waveform="gaussian_noise", seed=seed)).value
    noise = Noise(4)
    assert [noise.gaussian(), noise.gaussian()][1] * 2.0 == value
    for n, order in enumerate([9, 5, 5, 5, 5, 5]):
        chosen = settings(waveform="prbs", prbs_order=order, seed=6)
        value = source.sample(1.0 + n * 0.1, chosen).value
        assert value == 2.0 * Prbs(order, 6).chip(n)


def test_prbs_lasts_its_chip_time_and_its_period():
    times = [n * 0.05 for n in range(4 * 31)]
    values = run(times, waveform="prbs", prbs_order=5, chip_time=0.1)
    assert values[0::2] == values[1::2]
    assert values[:62] == values[62:]
    assert sum(values[0:62:2]) == 2.0


def test_change_of_chip_time_continues_sequence():
    steady = run([n * 0.1 for n in range(60)], waveform="prbs")
    source, values = SignalSource(), []
    for n in range(30):
        values.append(source.sample(n * 0.1, settings(waveform="prbs")).value)
    for n in range(30):
        chosen = settings(waveform="prbs", chip_time=0.2)
        values.append(source.sample(2.9 + (n + 1) * 0.2, chosen).value)
    assert values == steady


def test_multisine_is_the_sum_of_its_components_scaled_to_the_amplitude():
    times = [n * 0.037 for n in range(100)]
    components = list(
        zip(*(DEFAULTS["multisine_" + name] for name in ("amplitudes", "frequencies", "phases")))
    )
    expected = [
        1.0 + 2.0 / 1.75 * sum(a * math.sin(w * time + p) for a, w, p in components)
        for time in times
    ]
    assert run(times, waveform="multisine", offset=1.0) == pytest.approx(expected)


def test_multisine_components_keep_phase_when_others_change():
    source = SignalSource()
    one = {"multisine_amplitudes": [1.0], "multisine_phases": [0.0], "waveform": "multisine"}
    source.sample(1.0, settings(multisine_frequencies=[1.0], **one))
    source.sample(1.5, settings(multisine_frequencies=[3.0], **one))
    source.sample(1.5, settings(waveform="multisine"))
    value = source.sample(2.0, settings(multisine_frequencies=[3.0], **one)).value
    assert value == pytest.approx(2.0 * math.sin(1.0 + 3.0 * 1.0))


def test_readded_component_continues_its_phase():
    source = SignalSource()
    for time, frequencies in [(1.0, [1.0, 5.0]), (2.0, [1.0]), (3.0, [1.0, 7.0])]:
        count = len(frequencies)
        chosen = settings(
            waveform="multisine",
            multisine_amplitudes=[1.0] * count,
            multisine_frequencies=frequencies,
            multisine_phases=[0.0] * count,
        )
        value = source.sample(time, chosen).value
    assert value == pytest.approx(math.sin(3.0) + math.sin(21.0))


def test_a_multisine_without_amplitudes_is_silent():
    assert run([0.5], waveform="multisine", multisine_amplitudes=[0.0] * 3) == [0.0]
    empty = dict.fromkeys([name for name in DEFAULTS if name.startswith("multisine_")], [])
    assert run([0.5], waveform="multisine", **empty) == [0.0]


def test_reset_starts_phase_and_waveform_again():
    source, chosen = SignalSource(), settings(waveform="chirp")
    first = [source.sample(n * 0.1, chosen) for n in range(1, 20)]
    source.sample(50.0, settings(frequency=3.0))
    source.reset()
    assert [source.sample(n * 0.1, chosen) for n in range(1, 20)] == first


def test_each_waveform_that_can_be_chosen_can_be_made():
    assert tuple(SHAPES) == WAVEFORMS


def test_highest_frequency_of_each_waveform():
    highest = {name: settings(waveform=name).highest_frequency for name in WAVEFORMS}
    periodic = dict.fromkeys(["sine", "square", "triangle", "sawtooth", "pulse"], TWO_PI)
    others = {"chirp": 50.0, "multisine": 25.0, "prbs": math.pi / 0.1}
    assert highest == {**dict.fromkeys(WAVEFORMS, 0.0), **periodic, **others}
    assert settings(frequency=-3.0).highest_frequency == 3.0
    falling = settings(waveform="chirp", chirp_f0=-60.0, chirp_f1=50.0)
    assert falling.highest_frequency == 60.0
    assert settings(frequency=-31.4, rate=10.0).aliasing == ""
    above = "31.5 rad/s is above the Nyquist frequency of 31.4159 rad/s at a rate of 10 Hz"
    assert settings(frequency=-31.5, rate=10.0).aliasing == above
