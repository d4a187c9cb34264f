"""Ring buffers keep recent samples exactly, within their limits."""

from typing import Any, List, Tuple

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from topic_scope.analysis.ring import LIMIT, NOWHERE, Ring
from topic_scope.timing.nanoseconds import NS, array_to_ns, to_ns

HISTORY = 10.0


def seconds(most: float) -> "st.SearchStrategy[float]":
    """Return times that are exact in nanoseconds."""
    return st.floats(0.0, most).map(lambda time: round(time, 9))


BATCHES = st.lists(
    st.lists(st.tuples(seconds(3.0), st.floats(allow_nan=False)), max_size=60), max_size=40
)


def append(ring: Ring, times: Any, values: Any, received: Any) -> None:
    """Append samples whose times are in seconds."""
    ring.append(array_to_ns(numpy.array(times)), values, array_to_ns(numpy.array(received)))


def filled(ring: Ring, batches: List[List[Tuple[float, float]]]) -> List[Tuple[float, float]]:
    """Append batches of (time since the previous sample, value); return all samples."""
    now, everything = 0.0, []
    for batch in batches:
        times = []
        for step, value in batch:
            now = round(now + step, 9)
            times.append(now)
            everything.append((now, value))
        values = numpy.array([value for _, value in batch])
        append(ring, times, values, numpy.array(times) + 0.5)
    return everything


def content(ring: Ring, start: float = -9.0, end: float = 1e9) -> List[Tuple[float, float]]:
    times, values, _ = ring.between(to_ns(start), to_ns(end))
    return list(zip((times / NS).tolist(), values.tolist()))


@settings(max_examples=30)
@given(BATCHES)
def test_samples_within_the_history_are_kept(batches: list) -> None:
    ring = Ring(HISTORY)
    everything = filled(ring, batches)
    recent = [item for item in everything if item[0] >= everything[-1][0] - HISTORY]
    kept = content(ring)
    assert kept[len(kept) - len(recent) :] == recent
    assert kept == everything[len(everything) - len(kept) :]
    assert len(kept) == len(ring)


@settings(max_examples=30)
@given(BATCHES, st.integers(1, 50))
def test_no_more_samples_are_kept_than_allowed(batches: list, limit: int) -> None:
    ring = Ring(1e6, limit)
    everything = filled(ring, batches)
    assert content(ring) == everything[-limit:]


@settings(max_examples=30)
@given(BATCHES, seconds(50.0), seconds(50.0))
def test_a_span_has_its_samples(batches: list, start: float, length: float) -> None:
    ring = Ring(1e6)
    everything = filled(ring, batches)
    expected = [item for item in everything if start <= item[0] <= start + length]
    assert content(ring, start, start + length) == expected


def test_the_history_includes_its_end() -> None:
    ring = Ring(HISTORY)
    filled(ring, [[(0.5, 1.0), (0.5, 2.0)], [(HISTORY, 3.0)]])
    assert content(ring) == [(1.0, 2.0), (1.0 + HISTORY, 3.0)]


@pytest.mark.parametrize("batch", [1000, 1 << 18, LIMIT - 1, LIMIT, 3 * LIMIT])
def test_memory_of_a_fast_trace_is_bounded(batch: int) -> None:
    ring, largest = Ring(60.0), 0
    for start in range(0, 3 * LIMIT, batch):
        times = ((start + numpy.arange(batch)) * 1e-6).round(9)
        append(ring, times, times, times)
        largest = max(largest, sum(row.nbytes for row in ring._rows))
    assert len(ring) == LIMIT
    assert content(ring, times[-1])[-1] == (times[-1], times[-1])
    assert largest <= 2 * 24 * 2**20 == 2 * 24 * LIMIT  # spare capacity, to move samples rarely


def test_memory_stays_what_the_history_needs() -> None:
    ring = Ring(HISTORY)
    for second in range(1000):
        times = second + numpy.arange(100) / 100.0
        append(ring, times, times, times)
    assert len(ring) <= 100 * (HISTORY + 1)
    assert len(ring._rows[0]) <= 8 * 100 * HISTORY


@pytest.mark.parametrize("slow", [1, 10, 100])
def test_memory_is_released_when_a_topic_slows_down(slow: int) -> None:
    ring, sizes, everything = Ring(HISTORY), [], []
    for second in range(30):
        times = second + numpy.arange(20000 if second < 15 else slow) / 20000.0
        times = times.round(9)
        append(ring, times, times, times)
        everything += list(times)
        sizes.append(len(ring._rows[0]))
    assert sizes[14] >= 20000 * HISTORY
    assert sizes[-1] <= max(1024, 4 * slow * (HISTORY + 1))
    assert len(set(sizes[14:])) <= 5, "seldom"
    assert content(ring) == [(at, at) for at in everything if at >= times[-1] - HISTORY]


@settings(max_examples=30)
@given(st.lists(st.lists(seconds(9.0), max_size=20), max_size=20))
def test_late_samples_are_sorted_in_with_their_receipt_times(batches: list) -> None:
    ring, everything = Ring(1e6), []
    for batch in batches:
        numbers = numpy.arange(len(everything), len(everything) + len(batch), dtype=float)
        append(ring, numpy.array(batch), numbers, 100.0 + numbers)
        everything += zip(batch, numbers)
    assert content(ring) == sorted(everything)
    assert list(ring.between(-NS, to_ns(1e9))[2] / NS - 100.0) == [
        number for _, number in sorted(everything)
    ]


def test_shifted_samples_end_their_line() -> None:
    ring = Ring(HISTORY)
    filled(ring, [[(7.0, 1.0), (1.0, 2.0)]])
    ring.move(to_ns(-8.5))
    filled(ring, [[(0.5, 3.0)]])
    assert repr(content(ring)) == "[(-1.5, 1.0), (-0.5, 2.0), (-0.5, nan), (0.5, 3.0)]"


@settings(max_examples=30)
@given(BATCHES, BATCHES, seconds(40.0), seconds(40.0))
def test_pinned_samples_are_kept_beyond_the_history(
    first: list, later: list, start: float, length: float
) -> None:
    ring = Ring(HISTORY)
    filled(ring, first)
    shown = content(ring, start, start + length)
    ring.pin(to_ns(start), to_ns(start + length))
    now = content(ring)[-1][0] if len(ring) else 0.0
    for index, batch in enumerate(later):
        times = now + 3.0 * index + numpy.arange(len(batch)) / 100.0
        times = times.round(9)
        append(ring, times, numpy.arange(len(batch)), times)
        assert content(ring, start, start + length)[: len(shown)] == shown
    everything = content(ring)
    assert everything == sorted(everything, key=lambda sample: sample[0])
    ring.pin(*NOWHERE)
    assert len(content(ring)) == len(ring)


@settings(max_examples=30)
@given(
    BATCHES,
    st.lists(st.lists(seconds(1.0), max_size=20), max_size=20),
    seconds(40.0),
    seconds(40.0),
)
def test_late_samples_of_a_pinned_span_are_kept(
    first: list, later: list, start: float, length: float
) -> None:
    ring = Ring(HISTORY)
    filled(ring, first)
    ring.pin(to_ns(start), to_ns(start + length))
    expected = content(ring, start, start + length)
    now = content(ring)[-1][0] if len(ring) else 0.0
    for index, places in enumerate(later):
        times = [round(start + place * length, 9) for place in places] + [
            round(now + 3.0 * index, 9)
        ]
        numbers = 1000.0 * index + numpy.arange(len(times))
        append(ring, numpy.array(times), numbers, numbers)
        arrived = zip(times, numbers.tolist())
        expected += [one for one in arrived if start <= one[0] <= start + length]
        expected.sort(key=lambda sample: sample[0])
        assert content(ring, start, start + length) == expected
