"""The conditioner against the exact formula, and against the textbook's square root."""

import math
import struct
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from basic_comms.conditioning.conditioner import Conditioner
from basic_comms.conditioning.process_parameters import ProcessParameters
from nodekit import LARGEST_FLOAT32

TURN = 2.0 * math.pi
METHODS = ProcessParameters.method.choices


class Settings(NamedTuple):
    """The settings that a conditioner reads, as a node would hold them."""

    amplitude_scale: float = 0.5
    phase_shift: float = 0.5 * math.pi
    offset: float = 0.0
    keep_positive: bool = True
    input_offset: float = 0.0
    method: str = "sine"


def float32(value):
    """Round to float32."""
    return struct.unpack("f", struct.pack("f", value))[0]


class ExactSine:
    """Samples of an exact sine, rounded as on the wire."""

    def __init__(self, amplitude=2.0, frequency=6.2832, phase=0.3, mean=0.0):
        self.amplitude = amplitude
        self.frequency = frequency
        self.phase = phase
        self.mean = mean
        self.time = 0.0

    def sample(self, step=0.1):
        """Let time pass; return the next message's fields."""
        self.time += step
        self.phase += self.frequency * step
        return (
            float32(self.amplitude),
            float32(self.frequency),
            self.time,
            float32(self.mean + self.amplitude * math.sin(self.phase)),
        )

    def expected(self, settings):
        """Return the expected result of the conditioner for the latest sample."""
        peak = settings.amplitude_scale * self.amplitude
        result = peak * math.sin(self.phase + settings.phase_shift) + settings.offset
        if settings.keep_positive:
            result += max(0.0, abs(peak) - settings.offset)
        return result


scales = st.floats(-10.0, 10.0)
settings = st.builds(
    Settings,
    amplitude_scale=scales,
    phase_shift=st.floats(-20.0, 20.0),
    offset=st.floats(-10.0, 10.0),
    keep_positive=st.booleans(),
    input_offset=st.just(0.0),
    method=st.just("sine"),
)
sources = st.builds(
    ExactSine,
    amplitude=st.floats(-100.0, 100.0).filter(lambda amplitude: abs(amplitude) > 1e-3),
    frequency=st.floats(0.3, 30.0),
    phase=st.floats(-math.pi, math.pi),
)


@given(sources, st.lists(settings, min_size=8, max_size=8))
def test_result_is_the_exact_formula_through_any_change_of_settings(source, changes):
    conditioner = Conditioner()
    conditioner.process(*source.sample(), changes[0])
    for changed in changes:
        result = conditioner.process(*source.sample(), changed)
        peak = abs(changed.amplitude_scale * source.amplitude)
        assert result == pytest.approx(source.expected(changed), abs=1e-5 * peak + 1e-12)


wire = st.floats(-(2.0**100), 2.0**100, width=32)


@pytest.mark.parametrize("method", METHODS)
@given(samples=st.lists(st.tuples(wire, wire, st.floats(0, 1e9), wire), max_size=8), scale=scales)
def test_without_phase_shift_any_signal_passes_unchanged(samples, scale, method):
    conditioner = Conditioner()
    plain = Settings(scale, 0.0, keep_positive=False, method=method)
    for sample in samples:
        assert conditioner.process(*sample, plain) == scale * sample[3]


@pytest.mark.parametrize(
    "scale, offset, lowest",
    [(0.5, 0.0, 0.0), (0.5, 3.0, 2.0), (0.5, 0.25, 0.0), (-2.0, -1.0, 0.0), (0.0, 0.0, 0.0)],
)
def test_keep_positive_lifts_the_trough_to_zero_and_no_higher(scale, offset, lowest):
    conditioner = Conditioner()
    source = ExactSine(frequency=1.0, phase=0.0)
    lifted = Settings(amplitude_scale=scale, offset=offset)
    results = [conditioner.process(*source.sample(math.pi / 8), lifted) for _ in range(64)]
    assert min(results[1:]) == pytest.approx(lowest, abs=1e-5)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("frequency", [0.0, -6.2832, -1.0])
def test_phase_shift_with_zero_or_negative_frequency(frequency, method):
    conditioner = Conditioner()
    source = ExactSine(phase=0.4)
    shifted = Settings(1.0, 2.0, 0.0, keep_positive=False, method=method)
    for _ in range(250):
        conditioner.process(*source.sample(0.005), shifted)
    source.frequency = frequency
    for _ in range(100):
        result = conditioner.process(*source.sample(0.005), shifted)
        assert result == pytest.approx(source.expected(shifted), abs=1e-4)


def test_keep_positive_lifts_by_the_amplitude_of_the_sample_itself():
    conditioner = Conditioner()
    source = ExactSine()
    for amplitude in (2.0, 10.0, 0.1, -3.0):
        source.amplitude = amplitude
        for _ in range(3):
            result = conditioner.process(*source.sample(), Settings())
        assert result == pytest.approx(source.expected(Settings()), abs=1e-5 * abs(amplitude))


def test_input_offset_centres_the_signal_before_all_else():
    conditioner = Conditioner()
    source = ExactSine(mean=4.0)
    centred = Settings(phase_shift=0.7, input_offset=4.0)
    conditioner.process(*source.sample(), centred)
    for _ in range(30):
        result = conditioner.process(*source.sample(), centred)
        assert result == pytest.approx(source.expected(centred), abs=1e-5)


@given(st.floats(0.01, 5.0), st.integers(1, 5), st.floats(1e-3, 0.1))
def test_a_change_of_input_offset_does_not_upset_the_phase(wrong, count, step):
    conditioner = Conditioner()
    source = ExactSine(phase=0.0)
    right = Settings(keep_positive=False)
    for _ in range(200):
        conditioner.process(*source.sample(step), right)
    for _ in range(count):
        # Shifted by a quarter turn only the quadrature is seen: the offset itself must not show.
        result = conditioner.process(*source.sample(step), right._replace(input_offset=wrong))
        assert result == pytest.approx(source.expected(right), abs=2e-3)
    for _ in range(20):
        result = conditioner.process(*source.sample(step), right)
        assert result == pytest.approx(source.expected(right), abs=1e-5)


def test_the_phase_recovers_as_soon_as_the_input_offset_is_set_right():
    conditioner = Conditioner()
    source = ExactSine(mean=1.0)
    for _ in range(500):
        conditioner.process(*source.sample(), Settings())
    centred = Settings(input_offset=1.0)
    conditioner.process(*source.sample(), centred)
    for _ in range(20):
        result = conditioner.process(*source.sample(), centred)
        assert result == pytest.approx(source.expected(centred), abs=1e-5)


@pytest.mark.parametrize("field", range(4))
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_sample_that_is_not_finite_is_as_good_as_lost(field, value):
    conditioner = Conditioner()
    source = ExactSine()
    for _ in range(5):
        conditioner.process(*source.sample(), Settings())
    broken = list(source.sample())
    broken[field] = value
    assert conditioner.process(*broken, Settings()) is None
    assert conditioner.rejected == 1
    result = conditioner.process(*source.sample(), Settings())
    assert result == pytest.approx(source.expected(Settings()), abs=1e-5)
    assert conditioner.rejected == 1
    assert conditioner.restarts == 0


any_wire = st.floats(width=32)
numbers = st.floats(allow_nan=False, allow_infinity=False)
extreme = st.builds(
    Settings, numbers, numbers, numbers, st.booleans(), numbers, st.sampled_from(METHODS)
)


@given(st.lists(st.tuples(any_wire, any_wire, st.floats(), any_wire), max_size=6), extreme)
def test_every_result_fits_into_a_float32(samples, limits):
    conditioner = Conditioner()
    refused = 0
    for sample in samples:
        result = conditioner.process(*sample, limits)
        if result is None:
            refused += 1
        else:
            assert math.isfinite(float32(result))
    assert conditioner.rejected == refused


def test_the_largest_float32_is_a_result():
    plain = Settings(1.0, 0.0, keep_positive=False)
    assert Conditioner().process(1.0, 1.0, 0.0, LARGEST_FLOAT32, plain) == LARGEST_FLOAT32


def test_restarts_are_counted_and_answered():
    conditioner = Conditioner()
    source = ExactSine()
    for lap in range(3):
        source.time = 0.0
        for _ in range(5):
            result = conditioner.process(*source.sample(), Settings())
        assert result == pytest.approx(source.expected(Settings()), abs=1e-5)
        assert conditioner.restarts == lap


def test_quadrature_succeeds_where_square_root_fails():
    # cos = sqrt(1 - (y/A)^2): at the crest the rounded sample exceeds the amplitude.
    amplitude = 0.1
    conditioner = Conditioner()
    source = ExactSine(amplitude, 1.0, 0.0)
    failures = 0
    for index in range(2000):
        sample = source.sample(0.5 * math.pi if index % 2 else 1e-4)
        failures += (sample[3] / amplitude) ** 2 > 1.0
        result = conditioner.process(*sample, Settings())
        if index > 1:
            assert result == pytest.approx(source.expected(Settings()), abs=1e-6)
    assert failures > 0


def square(amplitude, count, index):
    """Return the fields of a square's sample, of count samples a period."""
    level = 1.0 if index % count < count // 2 else -1.0
    return (amplitude, float32(TURN), index / count, 3.0 + level * amplitude)


@given(st.integers(-30, 30), scales, st.booleans())
def test_a_delayed_square_is_the_square_shifted(lead, scale, keep_positive):
    count = 20
    settings = Settings(scale, TURN * lead / count, 1.0, keep_positive, 3.0, "delay")
    conditioner = Conditioner()
    for index in range(3 * count):
        result = conditioner.process(*square(2.0, count, index), settings)
        level = square(2.0, count, index + lead if index > count else index)[3] - 3.0
        lift = max(0.0, abs(2.0 * scale) - 1.0) if keep_positive else 0.0
        if index > count or index < (-lead) % count:
            assert result == pytest.approx(scale * level + 1.0 + lift, abs=1e-5 * abs(scale))


def test_methods_agree_on_a_sine_and_may_be_switched_at_any_sample():
    conditioner = Conditioner()
    source = ExactSine(frequency=6.0)
    for index in range(1200):
        sine = Settings(phase_shift=1.0)
        chosen = sine._replace(method=METHODS[index // 7 % 2])
        result = conditioner.process(*source.sample(0.005), chosen)
        if index > 210:
            assert result == pytest.approx(source.expected(sine), abs=1e-5)


def test_a_delayed_signal_is_centred_by_the_input_offset_in_force():
    conditioner = Conditioner()
    for index in range(40):
        result = conditioner.process(
            *square(2.0, 20, index), Settings(1.0, 0.15 * TURN, 0.0, False, float(index), "delay")
        )
        assert abs(result + index - 3.0) == pytest.approx(2.0, abs=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_stopped_generator_keeps_phase(method):
    settings = Settings(keep_positive=False, input_offset=1.0, method=method)
    conditioner, undisturbed, source = Conditioner(), Conditioner(), ExactSine(mean=1.0)
    for number in range(60):
        sample = source.sample(0.05)
        if number in (40, 41):
            for _ in range(3):
                stopped = conditioner.process(0.0, 0.0, sample[2], 0.25, settings)
                assert stopped == 0.5 * (0.25 - 1.0)
        result = conditioner.process(*sample, settings)
        assert result == undisturbed.process(*sample, settings)
    assert conditioner.restarts == 0
