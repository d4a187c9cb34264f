"""Bins contain the extremes of their samples, and all frames together every sample."""

import math
from typing import Dict, List, Tuple

import numpy
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.analysis.decimation import FEW, PLACES, all_bins, as_json, bin_of, extremes
from topic_scope.analysis.ring import Samples
from topic_scope.page.view import LATE_S, LiveView
from topic_scope.protocol import requests

EPOCH = 1.7e9
VALUES = st.floats(allow_nan=True, allow_infinity=True, width=32)
SAMPLES = st.lists(st.tuples(st.floats(0.0, 4.0), VALUES), max_size=80).map(
    lambda pairs: sorted(pairs, key=lambda pair: pair[0])
)


def arrays(pairs: List[Tuple[float, float]]) -> Samples:
    return (
        numpy.array([EPOCH + time for time, _ in pairs]),
        numpy.array([value for _, value in pairs]),
    )


def expected_bins(samples: Samples, width: float) -> Dict[int, List[float]]:
    """Return the extremes by bin, computed one by one; false if no sample is a number."""
    bins: Dict[int, List[float]] = {}
    for time, value in zip(*(part.tolist() for part in samples)):
        bins.setdefault(bin_of(time, width), []).append(value)
    finite = {index: list(filter(math.isfinite, values)) for index, values in bins.items()}
    return {
        index: [min(values), max(values)] if values else [False, False]
        for index, values in finite.items()
    }


@settings(max_examples=30)
@given(SAMPLES, st.floats(0.001, 2.0), st.integers(-5, 100), st.integers(0, 200))
def test_each_bin_has_the_extremes_of_its_samples(
    pairs: list, width: float, skipped: int, count: int
) -> None:
    samples = arrays(pairs)
    first = bin_of(EPOCH, width) + skipped
    result = as_json(extremes(*samples, first, count, width))
    expected = expected_bins(samples, width)
    assert len(result) == 2 * count
    for index in range(count):
        bounds = expected.get(first + index, [None, None])
        assert result[2 * index : 2 * index + 2] == bounds


@settings(max_examples=30)
@given(st.lists(SAMPLES, min_size=1, max_size=3), st.floats(0.001, 2.0), st.integers(-5, 50))
def test_few_samples_in_a_bin_have_positions(traces: list, width: float, skipped: int) -> None:
    samples, count = [arrays(pairs) for pairs in traces], 60
    first = bin_of(EPOCH, width) + skipped
    found = all_bins(samples, first, count, width, [math.inf] * len(samples))
    for (times, values), extreme, place in zip(samples, found.extremes, found.places):
        seen: Dict[int, List[Tuple[float, int]]] = {}
        for time, value in zip(times.tolist(), values.tolist()):
            if math.isfinite(value):
                index = bin_of(time, width)
                seen.setdefault(index, []).append((value, int((time / width - index) * PLACES)))
        for index in range(count):
            here = seen.get(first + index, [])
            here_places = list(zip(extreme, place))[2 * index : 2 * index + 2]
            if 1 <= len(here) <= FEW:
                assert sorted(here_places) == sorted([here[0], here[-1]])
            else:
                assert [one for _, one in here_places] == [-1, -1]


@settings(max_examples=30)
@given(SAMPLES, st.floats(0.1, 2.0), st.lists(st.floats(0.0, 5.0), max_size=12))
def test_lines_end_where_samples_are_missing_however_the_frames_fall(
    pairs: list, longest: float, moments: list
) -> None:
    pairs = [(time, value) for time, value in pairs if math.isfinite(value)]
    samples, screen = arrays(pairs), Screen()
    view, width = LiveView(requests.View(4.0, 100, None)), 0.04

    def until(now: float, start: float, end: float) -> Samples:
        times, values = source(samples, now)
        seen = (start <= times) & (times <= end)
        return times[seen], values[seen]

    view.select(["/a"])
    for now in sorted({EPOCH + moment for moment in [*moments, 5.0]}):
        frame = view.frame(
            now, lambda _, start, end: until(now, start, end), _same, lambda _: longest
        )
        assert frame is not None
        screen.show(frame)
    full = {bin_of(time, width) for time in samples[0]}
    for index in range(bin_of(EPOCH + 1.0, width), bin_of(EPOCH + 5.0, width) + 1):
        end = (index + 1) * width
        waited = end - max(samples[0][samples[0] < end], default=-math.inf)
        if abs(waited - longest) > 1e-6 and index not in full:
            assert (screen.bins[index] == [False, False]) == (waited > longest)


class Screen:
    """Page that joins frames as documented."""

    def __init__(self) -> None:
        self.bins: Dict[int, List[float]] = {}

    def show(self, frame: dict) -> None:
        values = frame["traces"]["/a"]
        if frame["reset"]:
            self.bins.clear()
        for index in range(len(values) // 2):
            self.bins[frame["first"] + index] = values[2 * index : 2 * index + 2]


def source(samples: Samples, until: float) -> Samples:
    seen = samples[0] <= until
    return samples[0][seen], samples[1][seen]


def _same(moment: float) -> float:
    """Return the start of new samples, for samples that arrive in time order."""
    return moment


@settings(max_examples=30)
@given(SAMPLES, st.lists(st.floats(0.0, 5.0), max_size=12), st.sampled_from([0.5, 2.0, 4.0]))
def test_frames_add_up_to_what_one_frame_shows(pairs: list, moments: list, window: float) -> None:
    """With any times of frames, no sample is lost or left over."""
    samples, screen = arrays(pairs), Screen()
    view = LiveView(requests.View(window, 50, None))
    view.select(["/a"])
    for now in sorted({EPOCH + moment for moment in [*moments, 5.0]}):
        frame = view.frame(now, lambda name, start, end: source(samples, now), _same)
        assert frame is not None
        screen.show(frame)
    width = window / 50
    expected = expected_bins(samples, width)
    for index in range(bin_of(EPOCH + 5.0 - window, width), bin_of(EPOCH + 5.0, width) + 1):
        assert screen.bins[index] == expected.get(index, [None, None])


def test_paused_time_sends_only_another_view() -> None:
    view, samples = LiveView(requests.View(1.0, 100, None)), arrays([(0.5, 1.0)])
    view.select(["/a"])

    def frame() -> object:
        return view.frame(EPOCH + 1.0, lambda *_: samples, _same)

    assert frame() is not None
    assert frame() is None
    view.show(requests.View(0.7, 100, None))
    assert frame() is not None
    assert frame() is None


def test_page_after_a_long_pause_is_reset() -> None:
    view = LiveView(requests.View(1.0, 100, None))
    nothing = (numpy.empty(0), numpy.empty(0))
    resets = [
        (view.frame(EPOCH + moment, lambda *_: nothing, _same) or {})["reset"]
        for moment in (0.0, 0.5, 1.0, 10.0, 10.1)
    ]
    assert resets == [True, False, False, True, False]


def test_completed_span_is_sent_once() -> None:
    samples = arrays([(0.5, 1.0), (1.5, -7.0), (2.5, 3.0)])
    view, screen = LiveView(requests.View(1.0, 10, EPOCH + 2.0)), Screen()
    view.select(["/a"])
    first = view.frame(EPOCH + 4.0, lambda *_: samples, _same)
    assert first is not None
    screen.show(first)
    assert screen.bins[bin_of(EPOCH + 1.5, 0.1)] == [-7.0, -7.0]
    assert view.frame(EPOCH + 4.1, lambda *_: samples, _same) is None
    view.show(requests.View(1.0, 10, EPOCH + 3.0))
    again = view.frame(EPOCH + 4.2, lambda *_: samples, _same)
    assert again is not None and again["reset"]


def test_late_samples_of_a_completed_span_are_sent() -> None:
    samples, asked = arrays([(1.5, -7.0), (2.5, 3.0)]), 0
    view, screen = LiveView(requests.View(1.0, 10, EPOCH + 2.0)), Screen()
    view.select(["/a"])
    changes = {5.0: 2.5, 10.0: 1.7, 15.0: 0.2}  # time of arrival: start of the change

    def changed_since(moment: float) -> float:
        nonlocal asked
        asked += 1
        new = [EPOCH + time for at, time in changes.items() if moment < EPOCH + at <= now]
        return min([moment, *new])

    sent = []
    for now in (EPOCH + index / 10.0 for index in range(35, 200)):
        frame = view.frame(now, lambda *_: samples, changed_since)
        if frame is not None:
            sent.append((round(now - EPOCH, 1), frame["reset"]))
            screen.show(frame)
            samples = arrays([(1.5, -7.0), (1.7, 8.0), (2.5, 3.0)])
    assert [reset for _, reset in sent] == [True, False, True] and sent[0][0] == 3.5
    assert 10.0 <= sent[1][0] <= 10.0 + LATE_S and 15.0 <= sent[2][0] <= 15.0 + LATE_S
    assert screen.bins[bin_of(EPOCH + 1.7, 0.1)] == [8.0, 8.0]
    assert asked <= 20  # seldom


def test_hidden_trace_is_not_read_and_shown_again_completely() -> None:
    samples = arrays([(1.5, -7.0)])
    asked: list = []

    def read(field: str, *_span: float) -> Samples:
        asked.append(field)
        return samples

    view = LiveView(requests.View(1.0, 10, None))
    view.select(["/a", "/b"])
    view.hide(["/b", "/later"])
    frames = [view.frame(EPOCH + 2.0 + 0.1 * index, read, _same) for index in range(3)]
    assert [list(frame["traces"]) for frame in frames if frame] == [["/a"]] * 3
    assert set(asked) == {"/a"} and view.shown == ["/a"]
    view.hide(["/a", "/b"])
    rest = view.frame(EPOCH + 2.3, read, _same)
    assert rest is not None and rest["traces"] == {} and not rest["reset"]
    view.hide(["/a"])
    again = view.frame(EPOCH + 2.4, read, _same)
    assert again is not None and again["reset"] and list(again["traces"]) == ["/b"]


def test_span_that_ends_later_continues() -> None:
    view = LiveView(requests.View(1.0, 10, EPOCH + 2.0))
    frames = [
        view.frame(EPOCH + moment, lambda *_: (numpy.empty(0), numpy.empty(0)), _same)
        for moment in (1.0, 1.9, 2.1, 2.1 + LATE_S, 2.2 + LATE_S)
    ]
    assert [frame is not None for frame in frames] == [True, True, True, True, False]


@settings(max_examples=30)
@given(SAMPLES, st.lists(st.floats(0.0, 2.0), max_size=60), st.lists(st.floats(0.0, 5.0)))
def test_late_samples_are_shown_at_their_times(pairs: list, delays: list, moments: list) -> None:
    samples, screen = arrays(pairs), Screen()
    received_at = samples[0] + numpy.resize([*delays, 0.0], len(samples[0]))
    view, before = LiveView(requests.View(4.0, 50, None)), 0.0
    view.select(["/a"])
    for now in sorted({EPOCH + moment for moment in [*moments, 8.0]}):
        new = samples[0][(before < received_at) & (received_at <= now)]
        there = received_at <= now
        frame = view.frame(
            now,
            lambda *_, seen=there: (samples[0][seen], samples[1][seen]),
            lambda moment, new=new: min([moment, *new.tolist()]),
        )
        before = now
        assert frame is not None
        screen.show(frame)
    expected = expected_bins(samples, 0.08)
    for index in range(bin_of(EPOCH + 4.0, 0.08), bin_of(EPOCH + 8.0, 0.08) + 1):
        assert screen.bins[index] == expected.get(index, [None, None])


def test_a_frame_counts_the_samples_of_bins_that_have_more_than_are_drawn() -> None:
    times = numpy.array([0.1, 0.2, 0.3, 1.5, 2.1, 2.2, 3.5])
    values = numpy.array([1.0, 2.0, 3.0, 4.0, 5.0, math.nan, 6.0])
    found = all_bins([(times, values), (times[3:], values[3:])], 0, 4, 1.0, [math.inf] * 2)
    assert found.counts.tolist() == [[3, 1, 1, 1], [0, 1, 1, 1]]
    view = LiveView(requests.View(4.0, 4, 4.0))
    view.select(["/dense", "/sparse"])
    traces = {"/dense": (times, values), "/sparse": (times[3:], values[3:])}

    def read(name: str, start: float, end: float) -> Tuple[numpy.ndarray, numpy.ndarray]:
        at, found = traces[name]
        inside = (at >= start) & (at <= end)
        return at[inside], found[inside]

    frame = view.frame(4.0, read, lambda _moment: -math.inf)
    assert frame is not None and frame["counts"] == {"/dense": [3, 1, 1, 1, 0]}
