"""Tests of the features of a generator and a process node, and of the channels."""

import math
from typing import Callable, List, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pid_control.signal_judging.channels import (
    AmbiguousChannelsError,
    Channel,
    oscillates,
    signal_of,
)
from pid_control.signal_judging.features import (
    HALF,
    RECTIFIED,
    SINE,
    ProcessFeatures,
    is_sine_like,
    process_features,
    signal_features,
)
from pid_control.signal_judging.sine_fit import wrapped


def record(of: Callable[[float], float], rate: float = 10.0, begin: float = 0.0) -> Channel:
    """Return 12 s of a function of time."""
    times = [begin + index / rate for index in range(int(12.0 * rate))]
    return Channel("/x", "data", times, [of(time) for time in times])


def processed(
    law: Callable[[float], float], delay: float = 0.04, frequency: float = 2.0
) -> ProcessFeatures:
    """Return the features of a loop that answers with a law of the phase of the latest message."""
    signal = record(lambda time: 3.0 * math.sin(frequency * time))
    sine = signal_features(signal).sine
    assert sine is not None
    output = Channel(
        "/y",
        "data",
        [time + delay for time in signal.times],
        [law(frequency * time) for time in signal.times],
    )
    found = process_features(output, signal.times, sine)
    assert found is not None
    return found


@given(
    st.floats(0.05, 5.0), st.floats(-3.0, 3.0), st.floats(-10.0, 10.0), st.sampled_from([0.0, 0.09])
)
def test_process_features_sine_returns_gain_shift_and_offset_whenever_the_loop_answers(
    gain: float, shift: float, offset: float, delay: float
) -> None:
    found = processed(lambda x: gain * 3.0 * math.sin(x + shift) + offset, delay)
    assert found.shape == SINE
    assert found.gain == pytest.approx(gain, rel=1e-3)
    assert found.offset == pytest.approx(offset, abs=1e-3 * (gain + abs(offset)))
    assert found.shift_error(shift) < 0.01
    assert found.shift_error(shift + 1.0) > 0.5
    assert found.not_finite == 0 and found.rate == pytest.approx(10.0)


def test_process_features_at_the_same_time_has_both_shifts() -> None:
    found = processed(lambda x: math.sin(x), 0.0)
    assert found.shifts[0] == pytest.approx(0.0, abs=1e-3)
    assert found.shifts[1] == pytest.approx(0.2, abs=1e-3)  # by the message 0.1 s before
    plain, leading = processed(math.sin), processed(lambda x: math.sin(x + 0.5))
    assert plain.shift_distance(found) < 1e-3
    assert leading.shift_distance(plain, 0.5) < 1e-3 < leading.shift_distance(plain, -0.5)


def test_process_features_output_before_the_first_message_does_not_count() -> None:
    found = processed(lambda x: -50.0 if x == 0.0 else math.sin(x), -0.04)
    assert found.lowest > -1.1 and found.distortion < 0.1


@pytest.mark.parametrize("law", [math.sin, lambda x: abs(math.sin(x))])
def test_process_features_constant_output_until_a_buffer_is_full_is_no_distortion(
    law: Callable[[float], float],
) -> None:
    found = processed(lambda x: -2.0 if x < 4.0 else law(x - 4.0))
    assert found.distortion < 0.05 and found.gain == pytest.approx(1.0 / 3.0, rel=0.05)
    assert found.shift_error(-4.0) < 0.05 and found.lowest > -1.1
    late = processed(lambda x: -2.0 if x < 18.0 else law(x - 4.0))  # less than a period is left
    assert late.distortion > 0.1
    other = processed(lambda x: -2.0 if x < 4.0 else law(x) + law(2.0 * x))
    assert other.distortion > 0.1 and other.lowest == -2.0


@given(st.floats(0.1, 2.0), st.floats(-1.4, 1.4), st.sampled_from([0.0, 2.0]))
def test_process_features_rectified_sine_is_recognised(
    gain: float, shift: float, offset: float
) -> None:
    found = processed(lambda x: offset + gain * 3.0 * abs(math.sin(x + shift)))
    assert found.shape == RECTIFIED
    assert found.gain == pytest.approx(gain, rel=0.05)
    assert found.shift_error(shift) < 0.05
    assert found.shift_error(shift + math.pi) < 0.05
    assert found.lowest == pytest.approx(offset, abs=0.4 * gain)
    assert found.distortion < 0.05


@given(st.floats(0.1, 2.0), st.floats(-3.0, 3.0))
def test_process_features_half_wave_is_recognised(gain: float, shift: float) -> None:
    found = processed(lambda x: max(0.0, gain * 3.0 * math.sin(x + shift)))
    assert found.shape == HALF
    assert found.gain == pytest.approx(gain, rel=0.02)
    assert found.shift_error(shift) < 0.02
    assert found.lowest == 0.0 and found.distortion < 1e-6


def test_process_features_half_wave_may_have_noise_but_no_values_below_0() -> None:
    for lowest, shape in ((0.05, HALF), (0.07, SINE), (-0.05, HALF), (-0.07, SINE)):
        found = processed(lambda x: max(0.0, 3.0 * math.sin(x)) or lowest)
        assert found.shape == shape
    clipped = processed(lambda x: max(-0.2, math.sin(x)))
    assert clipped.shape == SINE and clipped.distortion > 0.1


@pytest.mark.parametrize("shape", [RECTIFIED, HALF])
def test_process_features_shape_that_does_not_fit_is_a_distorted_sine(shape: str) -> None:
    for size, found in ((0.14, shape), (0.18, SINE)):
        wave = processed(
            lambda x: (
                max(0.0, math.sin(x) + size * math.sin(3.0 * x))
                if shape == HALF
                else abs(math.sin(x)) + size * math.sin(7.0 * x)
            )
        )
        assert wave.shape == found


def test_process_features_distortion_is_the_share_of_what_does_not_fit() -> None:
    third = 0.1 * math.sqrt(0.5)  # RMS
    found = processed(lambda x: 6.0 * (math.sin(x + 1.0) + 0.1 * math.sin(3.0 * x)))
    assert (found.shape, found.distortion) == (SINE, pytest.approx(third, rel=0.05))
    found = processed(lambda x: 6.0 * abs(math.sin(x + 1.0)) + 0.6 * math.sin(7.0 * x))
    assert (found.shape, found.distortion) == (RECTIFIED, pytest.approx(third, rel=0.1))
    found = processed(lambda x: 6.0 * max(0.0, math.sin(x) + 0.1 * math.sin(3.0 * x)))
    assert (found.shape, found.distortion) == (HALF, pytest.approx(third * math.sqrt(0.5), rel=0.2))


def test_process_features_other_shape_is_distorted() -> None:
    assert processed(lambda x: math.sin(3.0 * x)).distortion > 1.0
    assert processed(lambda x: math.copysign(1.0, math.sin(x))).distortion > 0.3


def test_process_features_nan_is_counted_and_left_out() -> None:
    found = processed(lambda x: math.nan if 1.0 < x < 2.0 else math.sin(x + 1.0))
    assert found.not_finite == 4 and found.rate == pytest.approx(10.0)
    assert found.shift_error(1.0) < 0.01 and found.distortion < 0.01


def test_process_features_of_constant_output_are_missing() -> None:
    signal = record(math.sin)
    sine = signal_features(signal).sine
    assert sine is not None
    assert process_features(record(lambda time: 2.0), signal.times, sine) is None
    assert process_features(record(math.sin, begin=-50.0), signal.times, sine) is None


@pytest.mark.parametrize(
    ("of", "is_like"),
    [
        (lambda time: math.sin(2.0 * time), True),
        (lambda time: math.sin(2.0 * time) + 0.40 * math.sin(6.0 * time), True),
        (lambda time: math.sin(2.0 * time) + 0.45 * math.sin(6.0 * time), False),
        (lambda time: max(0.0, math.sin(2.0 * time + 0.8)), True),  # 0 in the last quarter period
        (lambda time: 10.0 + 5.0 * 0.5 ** (10.0 * time), False),
        (lambda time: 1.0, False),
        (lambda time: 3.0 * time, False),
    ],
)
def test_is_sine_like_settling_output_is_not(of: Callable[[float], float], is_like: bool) -> None:
    assert is_sine_like(record(of), 2.0, 0.0, 12.0) is is_like


def test_is_sine_like_half_wave_may_end_with_its_zeros() -> None:
    half = record(lambda time: max(0.0, math.sin(time + 0.45)))
    assert set(half.between(9.0).values) == {0.0}
    assert is_sine_like(half, 1.0, 0.0, 12.0)
    # What only rises for less than a period may settle.
    assert not is_sine_like(record(lambda time: math.sin(0.1 * time - 0.6)), 0.1, 0.0, 12.0)


def test_is_sine_like_only_the_given_time_counts() -> None:
    found = record(lambda time: math.sin(2.0 * time) if 3.0 <= time < 9.0 else 50.0)
    assert is_sine_like(found, 2.0, 3.0, 9.0)
    assert not is_sine_like(found, 2.0, 2.5, 9.0) and not is_sine_like(found, 2.0, 3.0, 9.5)
    assert not is_sine_like(found, 2.0, 3.0, 12.1)
    # Its last quarter must oscillate: constant from 7.5 s to 9 s.
    settled = record(lambda time: math.sin(2.0 * min(time, 7.49)))
    assert not is_sine_like(settled, 2.0, 3.0, 9.0)


@given(st.floats(0.0, 3.0), st.floats(1.0, 9.0), st.booleans())
def test_is_sine_like_rest_of_a_buffer_is_not(phase: float, rest: float, holds: bool) -> None:
    """A node that delays the signal sends what it has stored, then nothing or the last value."""
    sent = record(lambda time: math.sin(min(time, rest) + phase))
    assert not is_sine_like(sent if holds else sent.between(0.0, rest), 1.0, 0.0, 12.0)


def test_signal_features_of_a_ramp_lack_a_sine() -> None:
    assert signal_features(record(lambda time: 1.0)).sine is None
    assert signal_features(Channel("/x", "data", [], [])) == (None, None)
    odd = signal_features(record(lambda time: math.nan if time < 1.0 else math.sin(time)))
    assert odd.rate == pytest.approx(10.0) and odd.sine is not None and odd.sine.distortion < 1e-6


def fields(*functions: Tuple[str, Callable[[float], float]]) -> List[Channel]:
    return [record(of)._replace(field=name) for name, of in functions]


def test_signal_of_is_the_oscillating_value() -> None:
    channels = fields(
        ("amplitude", lambda time: 2.0), ("time_x", lambda time: time), ("q", math.sin)
    )
    found = signal_of(channels)
    assert found is not None and found.field == "q" and found.name == "/x/q"
    assert signal_of(channels[:2]) is None


@pytest.mark.parametrize("names", [("a", "b"), ("signal_a", "signal_b")])
def test_signal_of_several_uses_names_or_lists_them(names: Tuple[str, str]) -> None:
    channels = fields(("a", math.sin), ("y", math.cos))
    assert signal_of(channels) == channels[1]
    ranks = ("signal", "proc", "sin", "output", "value", "data", "y")
    pairs = [
        ((worse, f"The_{better}" if better != "y" else better), 1)
        for better, worse in zip(ranks, (*ranks[1:], "x"))
    ]
    for words, index in (*pairs, (("yaw", "y"), 1), (("signal_a", "signal_output"), 1)):
        channels = fields((words[0], math.sin), (words[1], math.cos))
        assert signal_of(channels) == channels[index]
    channels = fields((names[0], math.sin), (names[1], math.cos))
    with pytest.raises(AmbiguousChannelsError, match=f"/x/{names[0]}, /x/{names[1]}"):
        signal_of(channels)


def test_oscillates_ignores_nan() -> None:
    assert oscillates(record(lambda time: math.nan if time < 3.0 else math.sin(time)))
    assert not oscillates(record(lambda time: math.nan))


@pytest.mark.parametrize(
    ("values", "is_oscillating"),
    [
        ([0.0, 1.0], False),
        ([0.0, 1.0, 0.0], True),
        ([0.0, 1.0, 1.0, 2.0], False),
        ([2.0, 1.0, 1.0, 0.0], False),
        ([1.0, 1.0 + 1e-9, 1.0], False),
    ],
)
def test_oscillates_rises_and_falls(values: List[float], is_oscillating: bool) -> None:
    assert oscillates(Channel("/x", "", range(len(values)), values)) is is_oscillating


@pytest.mark.parametrize(
    ("steps", "is_regular"),
    [
        ([0.1] * 19 + [9.0], True),
        ([0.1] * 17 + [9.0] * 3, False),
        ([0.1] * 12 + [0.14] * 8, True),
        ([0.1] * 12 + [0.16] * 8, False),
        ([0.16] * 12 + [0.1] * 8, True),  # compared with the median, not with the shortest
    ],
)
def test_channel_is_regular_if_nearly_all_intervals_are_equal(
    steps: List[float], is_regular: bool
) -> None:
    times = [sum(steps[:count]) for count in range(len(steps) + 1)]
    assert Channel("/x", "", times, times).is_regular() is is_regular


def test_channel_between_and_rate() -> None:
    channel = record(math.sin).between(2.0, 3.0)
    assert (channel.times[0], len(channel.times)) == (2.0, 10)
    assert channel.rate() == pytest.approx(10.0)
    assert channel.between(2.0, 2.15).rate() is None
    assert channel.between(2.0, 2.25).rate() == pytest.approx(10.0)
    assert channel.values == [math.sin(time) for time in channel.times]
    assert (channel.name, channel._replace(field="").name) == ("/x/data", "/x")
    assert channel._replace(times=[2.0] * 10).rate() is None
    assert channel._replace(times=[2.0, 2.0, 3.0]).rate() == 2.0
    assert wrapped(0.0) == 0.0
