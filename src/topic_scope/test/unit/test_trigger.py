"""Exact crossings, and the trigger messages of a page."""

import math
from typing import List, Optional

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.analysis.ring import Samples
from topic_scope.page.trigger import TriggerWatch, crossings
from topic_scope.protocol import requests

WINDOW = 1.0


def sine(end: float, frequency: float = 1.0, rate: float = 1000.0) -> Samples:
    times = numpy.arange(int(end * rate)) / rate
    return times, numpy.sin(2 * math.pi * frequency * times)


@settings(max_examples=30)
@given(st.floats(-0.9, 0.9), st.booleans(), st.floats(0.5, 5.0))
def test_crossings_of_a_sine_are_exact(level: float, rising: bool, frequency: float) -> None:
    found = crossings(*sine(3.0, frequency), level, rising)
    phase = math.asin(level) / (2 * math.pi)
    first = phase % 1.0 if rising else (0.5 - phase) % 1.0
    expected = [(first + turn) / frequency for turn in range(16)]
    expected = [time for time in expected if 0.001 <= time <= 2.998]
    inner = [time for time in found if 0.001 <= time <= 2.998]
    assert inner == pytest.approx(expected, abs=1e-4)


@settings(max_examples=30)
@given(
    st.lists(st.floats(allow_nan=True), max_size=50),
    st.floats(allow_nan=False, allow_infinity=False),
)
def test_each_crossing_is_between_its_samples(values: List[float], level: float) -> None:
    numbers = numpy.array(values, float)
    times = numpy.arange(len(values), dtype=float)
    finite = [(t, v) for t, v in zip(times, values) if math.isfinite(v)]
    for rising in (True, False):
        found = crossings(times, numbers, level, rising)
        pairs = [
            (one[0], other[0])
            for one, other in zip(finite, finite[1:])
            if (one[1] < level <= other[1] if rising else one[1] > level >= other[1])
        ]
        assert len(found) == len(pairs)
        assert all(start <= moment <= end for moment, (start, end) in zip(found, pairs))


def test_crossing_in_a_gap_is_at_the_second_sample() -> None:
    """After a gap, and on a stepped trace, the crossing is at the second sample."""
    times, values = numpy.array([0.0, 0.1, 5.0, 5.1, 5.2]), numpy.array([0.0, 0.0, 1.0, 0.0, 1.0])
    for longest, moments in ((math.inf, [2.55, 5.15]), (0.5, [5.0, 5.15]), (0.0, [5.0, 5.2])):
        found = crossings(times, values, 0.5, True, longest=longest)
        assert found.tolist() == pytest.approx(moments)
        request = requests.Trigger("single", "/a", 0.5, True)
        watch = TriggerWatch(request, 0.0)
        heard = watch.update(6.0, WINDOW, lambda *_: (times, values), lambda _: longest)
        assert heard is not None and heard["time"] == pytest.approx(moments[0])


def states_of(mode: str, moments: List[float], samples: Samples, level: float = 0.0) -> List[tuple]:
    """Return the trigger states that a page receives at some times."""
    request = requests.Trigger(mode, "/a", level, True)
    watch = TriggerWatch(request, 0.0)
    messages: List[Optional[dict]] = []
    for now in moments:

        def source(_name: str, start: float, end: float) -> Samples:
            seen = (samples[0] >= start) & (samples[0] <= end)
            return samples[0][seen], samples[1][seen]

        messages.append(watch.update(now, WINDOW, source))
    return [(message["state"], message["time"]) for message in messages if message]


@pytest.mark.parametrize("mode", ["off", "normal", "single"])
def test_each_state_has_the_number_of_its_request(mode: str) -> None:
    for number in (0, 7):
        watch = TriggerWatch(requests.Trigger(mode, "/a", 0.0, True, number), 0.0)
        messages = [watch.update(now, WINDOW, lambda *_: sine(now)) for now in (0.5, 1.5)]
        assert [message["number"] for message in messages if message] == [number] * (
            1 if mode == "off" else 2
        )


MOMENTS = [index / 40 for index in range(200)]


def test_single_reports_one_crossing() -> None:
    assert states_of("single", MOMENTS, sine(5.0)) == [
        ("armed", None),
        ("triggered", pytest.approx(1.0, abs=1e-6)),
    ]


def test_normal_reports_the_next_crossing_after_the_last_is_shown() -> None:
    found = states_of("normal", MOMENTS, sine(5.0, frequency=3.0))
    assert [state for state, _ in found] == ["armed"] + ["triggered"] * (len(found) - 1)
    times = [time for _, time in found[1:]]
    # Held for half a window, 0.5 s: every other of the crossings at n / 3 s.
    assert times[:4] == pytest.approx([1 / 3, 1.0, 5 / 3, 7 / 3], abs=1e-5)


def test_normal_reports_missing_crossings() -> None:
    times, values = sine(5.0)
    values[times > 1.5] = -1.0
    found = states_of("normal", MOMENTS, (times, values))
    assert [state for state, _ in found] == ["armed", "triggered", "armed"]
    assert found[-1] == ("armed", None)


def test_a_level_that_is_not_reached_stays_armed() -> None:
    assert states_of("normal", MOMENTS, sine(5.0), level=1.5) == [("armed", None)]


def test_off_is_reported_once() -> None:
    assert states_of("off", MOMENTS, sine(5.0)) == [("off", None)]


@settings(max_examples=30)
@given(st.lists(st.floats(0.0, 4.9), min_size=1, max_size=30))
def test_no_crossing_is_missed_at_any_polling_times(moments: List[float]) -> None:
    found = states_of("single", sorted(moments) + [4.95], sine(5.0, frequency=0.25), level=0.5)
    assert found[-1] == ("triggered", pytest.approx(1 / 3, abs=1e-5))


@settings(max_examples=30)
@given(st.integers(0, 1000), st.lists(st.floats(0.0, 4.9), max_size=10))
def test_noise_within_the_hysteresis_does_not_trigger(seed: int, moments: List[float]) -> None:
    times, values = sine(4.9)
    noise = numpy.random.RandomState(seed).uniform(-0.1, 0.1, len(times))
    found = crossings(times, values + noise, 0.0, True, hysteresis=0.25)
    assert found == pytest.approx([1.0, 2.0, 3.0, 4.0], abs=0.05)
    assert len(crossings(times, values + noise, 0.0, True)) > 10
    # At any polling times, hence with any parts of the samples.
    request = requests.Trigger("single", "/a", 0.0, True, 0, hysteresis=0.25)
    watch, heard = TriggerWatch(request, 0.0), []
    for now in sorted(moments) + [4.95]:

        def source(_name: str, start: float, end: float) -> Samples:
            seen = (times >= start) & (times <= end)
            return times[seen], (values + noise)[seen]

        heard.append(watch.update(now, WINDOW, source))
    assert [one["time"] for one in heard if one and one["time"]] == [found[0]]


def test_holdoff_and_position_say_when_the_next_crossing_counts() -> None:
    for changes, apart in (({"holdoff": 1.5}, 5 / 3), ({"position": 0.1}, 1.0), ({}, 2 / 3)):
        request = requests.Trigger("auto", "/a", 0.0, True)._replace(**changes)
        watch = TriggerWatch(request, 0.0)
        heard = [watch.update(now, WINDOW, lambda *_: sine(5.0, frequency=3.0)) for now in MOMENTS]
        times = [one["time"] for one in heard if one and one["time"]]
        assert times[1] - times[0] == pytest.approx(apart, abs=1e-4), changes


@pytest.mark.parametrize("mode, late", [("normal", 0.8), ("auto", 0.8), ("auto", 2.5)])
def test_trace_with_late_stamps_triggers(mode: str, late: float) -> None:
    window = 0.4
    times, values = sine(10.6)
    watch, heard = TriggerWatch(requests.Trigger(mode, "/a", 0.0, True), 0.0), []
    for now in (index / 40 for index in range(int((10.6 + late) * 40))):

        def source(_name: str, start: float, end: float) -> Samples:
            seen = (times >= start) & (times <= end) & (times <= now - late)
            return times[seen], values[seen]

        heard.append(watch.update(now, window, source))
    found = [one["time"] for one in heard if one and one["state"] == "triggered"]
    assert found == pytest.approx([float(second) for second in range(1, 11)], abs=1e-5)
