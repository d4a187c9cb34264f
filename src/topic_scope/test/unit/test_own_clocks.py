"""Traces with stamps of other clocks, of clocks set back, or without stamps."""

import math
import struct
from typing import List

import numpy
import pytest
from bags import nanoseconds
from geometry_msgs.msg import PointStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from std_msgs.msg import Float32
from test_recorder import FakeSource, header, recording

from basic_comms.msg import signal_msg
from topic_scope.messages.message_layout import layout_of, parse
from topic_scope.sampling.message_source import Batch
from topic_scope.sampling.recorder import Recorder
from topic_scope.sampling.traces import Stream
from topic_scope.timing.nanoseconds import to_ns


@pytest.mark.parametrize("own", [5.0, 1700000.0])
def test_type_with_another_clock_continues_the_trace(own: float) -> None:
    """The earlier samples use the scope's clock until they expire."""
    source = FakeSource()
    source.time = 1.7e9
    made = recording(source, "/a/data")
    timed_header = {"type": "a/Timed", "message_definition": "float64 time_x\nfloat32 data"}
    for second in range(40):
        times = [source.time + 0.1 * index for index in range(10)]
        if second < 5:
            batch = Batch(header(Float32), nanoseconds(times), [struct.pack("<f", second)] * 10)
        else:
            data = [struct.pack("<df", time - 1.7e9 + own, second) for time in times]
            batch = Batch(timed_header, nanoseconds(times), data)
        source.topics["/a"].batches.append(batch)
        source.time += 1.0
        made.update()
        stamps, found = made.samples("/a/data", -math.inf, math.inf)
        there = numpy.isfinite(found)
        expected = [1.7e9 + 0.1 * index for index in range(10 * (second + 1))]
        kept = [time for time in expected if time >= expected[-1] - 10.0 - 1e-3]
        numpy.testing.assert_allclose(stamps[there], kept, rtol=0.0, atol=1e-3)
        numpy.testing.assert_allclose(found[there], [int(time - 1.7e9 + 0.01) for time in kept])


def test_a_clock_that_is_set_back_within_a_batch_begins_a_new_line() -> None:
    """A bag delivers large batches."""
    stream = Stream("/a", "time_x")
    trace = stream.record(("signal_y",), 100.0)
    own = [100.0 + 0.1 * index for index in range(20)] + [0.1 * index for index in range(20)]
    received = [1.7e9 + 0.1 * index for index in range(40)]
    data = [struct.pack("<ffdf", 2.0, 1.0, time, 5.0) for time in own]
    stream.add(layout_of(signal_msg), Batch(header(signal_msg), nanoseconds(received), data))
    times, found = trace.samples(0.0, 2e9)
    assert len(times) == 41 and numpy.isnan(found[20])
    numpy.testing.assert_allclose(numpy.delete(times, 20), received, atol=1e-3)


def test_unset_stamp_is_ignored_until_stamps_are_set() -> None:
    stream = Stream("/a", "")
    trace = stream.record(("point", "x"), 100.0)

    def add(first: int, last: int, begin: int) -> None:
        received = [1.7e9 + 0.01 * index for index in range(first, last)]
        data = [
            struct.pack("<IIII3d", 0, begin, begin and index * 10**7, 0, index, 0.0, 0.0)
            for index in range(first, last)
        ]
        stream.add(
            layout_of(PointStamped), Batch(header(PointStamped), nanoseconds(received), data)
        )

    add(0, 50, 0)
    assert (stream.timestamp, trace.longest_step) == ("received", 0.25)
    add(50, 99, 7)
    assert stream.timestamp == "stamp" and abs(trace.longest_step - 0.05) < 1e-6
    times, found = trace.samples(0.0, 2e9)
    assert len(times) == 100 and numpy.isnan(found[50])
    numpy.testing.assert_allclose(numpy.delete(found, 50), numpy.arange(99))
    numpy.testing.assert_allclose(
        numpy.delete(times, 50), 1.7e9 + 0.01 * numpy.arange(99), rtol=0.0, atol=1e-5
    )


@pytest.mark.parametrize("speed", [0.5, 2.0])
def test_paused_span_stays_during_a_simulation_at_another_speed(
    speed: float,
) -> None:
    source = FakeSource()
    made = recording(source, "/a/signal_y")

    def go_on(seconds: int, begin: float = 0.0) -> None:
        for first in range(0, 100 * seconds, 10):
            times = [source.time + 0.01 * index for index in range(10)]
            data = [
                struct.pack("<ffdf", 2.0, 1.0, begin + speed * (time - 1000.0), time - 1000.0)
                for time in times
            ]
            source.topics["/a"].batches.append(Batch(header(signal_msg), nanoseconds(times), data))
            source.time += 0.1
            made.update()

    go_on(15)
    end = source.time
    shown = values_in(made, end - 4.0, end)
    assert len(shown) > 100
    made.pin({"/a/signal_y": (end - 4.0, end + 1.0)})
    go_on(20)
    kept = values_in(made, end - 4.0, end)
    assert kept[: len(shown)] == shown  # by such a clock, part of the span arrives only now
    made.pin({"/a/signal_y": (end - 5.0, end + 1.0)})  # moved within the stored samples
    assert values_in(made, end - 4.0, end) == kept
    go_on(2, -1000.0)  # the simulation restarts
    assert values_in(made, end - 4.0, end) == kept
    trace = made.trace("/a/signal_y")
    assert trace is not None and trace.span is not None and trace.span[0] <= end - 3.9
    made.pin({})
    latest = values_in(made, source.time - 1.5, source.time)
    assert min(latest) > 30.0


def values_in(made: Recorder, start: float, end: float) -> List[float]:
    """Return the values in a time span."""
    found = made.samples("/a/signal_y", start, end)[1]
    return [value for value in found.tolist() if not math.isnan(value)]


@settings(max_examples=30)
@given(st.lists(st.floats(0.0, 3.0), min_size=1, max_size=50, unique=True).map(sorted))
def test_parts_of_a_span_have_each_sample_once(times: List[float]) -> None:
    """Own times are finer than the scope's, which are large."""
    stream = Stream("/a", "time_x")
    trace = stream.record(("signal_y",), 10.0)
    data = [struct.pack("<ffdf", 2.0, 1.0, time, index) for index, time in enumerate(times)]
    stream.add(
        layout_of(signal_msg), Batch(header(signal_msg), nanoseconds([1.7e9] * len(data)), data)
    )
    ends = sorted({stream.offset + end for end in nanoseconds((-1.0, *times, 5.0))})
    parts = [trace.rows(begin, end - 1)[1] for begin, end in zip(ends, ends[1:])]
    assert numpy.concatenate(parts).tolist() == list(range(len(times)))


TIMED = parse("a/Timed", "float64 time_x\nfloat64 x")


def timed(stream: Stream, first: int, values: List[float]) -> float:
    """Add messages, 10 a second, with times since the start of their node."""
    times = [first / 10 + index / 10 for index in range(len(values))]
    received = nanoseconds(1.7e9 + time for time in times)
    data = [struct.pack("<dd", 5.0 + time, value) for time, value in zip(times, values)]
    return stream.add(TIMED, Batch({}, received, data))


def test_type_without_stamps_continues_the_trace_of_another_clock() -> None:
    stream = Stream("/a", "")
    trace = stream.record(("x",), 100.0)
    timed(stream, 0, [1.0] * 20)
    before = trace.samples(0.0, 2e9)[0]
    plain = Batch({}, nanoseconds([1.7e9 + 3.0]), [struct.pack("<d", 2.0)])
    stream.add(parse("a/Plain", "float64 x"), plain)
    times, values = trace.samples(0.0, 2e9)
    there = numpy.isfinite(values)
    assert times[there] == pytest.approx([*before, 1.7e9 + 3.0], abs=1e-5)


def test_late_message_is_read_by_its_own_type_though_the_type_changes() -> None:
    stream = Stream("/a", "")
    trace = stream.record(("x",), 100.0)
    timed(stream, 0, [1.0] * 20)
    late = Batch({}, nanoseconds([1.7e9 + 2.0]), [struct.pack("<dd", 6.05, 3.0)])
    assert stream.add(TIMED, late) == math.inf  # it waits for others
    padded = Batch({}, nanoseconds([1.7e9 + 2.1]), [struct.pack("<ddd", 7.1, 9.0, 2.0)])
    stream.add(parse("a/Padded", "float64 time_x\nfloat64 pad\nfloat64 x"), padded)
    values = trace.samples(0.0, 2e9)[1].tolist()
    assert values == [*[1.0] * 11, 3.0, *[1.0] * 9, 2.0]


def test_earliest_of_disordered_stamps_is_reported() -> None:
    stream = Stream("/a", "")
    stream.record(("x",), 100.0)
    timed(stream, 0, [1.0] * 20)
    received = nanoseconds([1.7e9 + 2.0, 1.7e9 + 2.1])
    data = [struct.pack("<dd", time, 1.0) for time in (7.0, 6.85)]
    assert stream.add(TIMED, Batch({}, received, data)) == pytest.approx(1.7e9 + 1.85, abs=1e-6)


def test_formulas_need_no_samples_from_before_a_gap() -> None:
    stream = Stream("/a", "")
    trace = stream.record(("x",), 10.0)
    for first in range(0, 50, 10):
        timed(stream, first, [1.0] * 10)
    assert trace.whole_from == to_ns(-math.inf)
    timed(stream, 90, [1.0])
    for first in range(130, 180, 10):
        timed(stream, first, [1.0] * 10)
    # The first is alone in 4 s, more than five usual intervals.
    assert trace.samples(0.0, 2e9)[0][:2] == pytest.approx([1.7e9 + 9.0, 1.7e9 + 13.0], abs=1e-5)
    assert trace.whole_from == pytest.approx(to_ns(1.7e9 + 8.5), abs=10**6)
