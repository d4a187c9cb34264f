"""Difference of two traces and other formulas, with samples in any order of arrival."""

import subprocess
import sys
import math
import struct
from typing import Any, Dict, List, Sequence

import numpy
import pytest
from bags import nanoseconds
from hypothesis import given, settings
from hypothesis import strategies as st
from std_msgs.msg import Float64
from test_recorder import FakeSubscription, FakeSource, header

from topic_scope.formulas.names import expand, terms
from topic_scope.messages.fields import FieldError
from topic_scope.messages.layout_cache import Layouts
from topic_scope.page.view import LiveView
from topic_scope.protocol.checks import fields_of
from topic_scope.protocol.requests import View
from topic_scope.sampling.message_source import Batch
from topic_scope.sampling.recorder import Recorder
from topic_scope.timing.nanoseconds import NS, to_ns

TYPES = {"/a": "std_msgs/Float64", "/b": "std_msgs/Float64", "/s": "basic_comms/signal_msg"}
NAME = "/a/data-/b/data"


class TimedSource(FakeSource):
    """Source whose messages have given times of receipt."""

    def __init__(self) -> None:
        super().__init__()
        self.topics = {topic: FakeSubscription() for topic in TYPES}

    def receive(self, topic: str, times: Sequence[float], values: Sequence[float]) -> None:
        data = [struct.pack("<d", value) for value in values]
        self.topics[topic].batches.append(Batch(header(Float64), nanoseconds(times), data))


def recording(source: TimedSource, *names: str) -> Recorder:
    made = Recorder(source, Layouts(), 60.0)
    made.set_topics(TYPES)
    made.want(names, source.time)
    return made


def test_names() -> None:
    assert terms("/a/x") == ("/a/x",)
    assert terms("/a/x.unwrap@stamp-/b[1]/y@t") == ("/a/x.unwrap@stamp", "/b[1]/y@t")
    assert expand("a/x-/b/y") == ["/a/x-/b/y"]
    assert expand("/a/x:y") == ["/a/x", "/a/y"]
    assert fields_of(["/a/x.yaw-/b/y@t"]) == ("/a/x.yaw-/b/y@t",)
    for wrong in ("/a-2", "/a/x-/b/y-/c/z", "/a/x:y-/b/z", "/a-/", "-/a", "/a/x--/b", "/a-/b.eval"):
        with pytest.raises(FieldError):
            expand(wrong)
        assert fields_of([wrong]) == (wrong,)


def test_each_name_is_one_field() -> None:
    made = recording(TimedSource(), NAME)
    assert made.expand(NAME) == [NAME]
    assert made.expand("/s/signal_y@time_x-/a") == ["/s/signal_y@time_x-/a/data"]
    assert made.expand("/later/x-/a/data") == ["/later/x-/a/data"]
    with pytest.raises(FieldError, match="denotes several"):
        made.expand("/a/data-/s")
    assert (
        made.problem("/a/data-/b/nothing") == "/b/nothing: there is no nothing in std_msgs/Float64"
    )
    assert made.problem("/later/x-/a/data") == "/later/x: the topic does not exist yet"
    assert made.problem(NAME) is None and made.problem("/a/data") is None


def test_slow_second_trace_is_not_a_problem() -> None:
    source = TimedSource()
    made = recording(source, NAME)
    for second in range(1000, 1200):
        source.time = float(second)
        source.receive("/a", [source.time], [1.0])
        if second % 8 == 0:  # values may lie between two that are 40 s apart
            source.receive("/b", [source.time], [0.5])
        made.update()
    assert len(made.samples(NAME, -math.inf, math.inf)[0]) > 5
    assert made.problem(NAME) is None


def test_second_trace_is_interpolated_but_not_extrapolated() -> None:
    source = TimedSource()
    made = recording(source, NAME)
    assert source.wanted == ["/a", "/b"]
    assert made.trace(NAME) is not None and made.samples(NAME, 0.0, 1e9)[0].tolist() == []
    source.receive("/a", [999.0, 999.5, 1000.0, 1000.1, 1000.2, 1000.3], [1, 2, 3, 4, 5, 6])
    source.receive("/b", [999.4, 999.6, 999.8, 1000.0, 1000.2], [0, 10, 20, 30, 40])
    source.time = 1001.0
    made.update()
    times, values = made.samples(NAME, 999.2, 1e9)
    assert times.tolist() == [999.5, 1000.0, 1000.1, 1000.2]
    assert values == pytest.approx([-3.0, -27.0, -31.0, -35.0])
    before = made.samples(NAME, 0.0, 999.2)  # before the start of the second trace
    assert before[0].tolist() == [999.0] and math.isnan(before[1][0])
    trace = made.trace(NAME)
    assert trace is not None and trace.span == (999.0, 1000.2)
    assert (trace.rows(to_ns(999.2), to_ns(1e9))[2] / NS).tolist() == times.tolist()
    assert 1001.0 - trace.last / NS == pytest.approx(0.8)
    assert trace.stream.topic == "/a" and made.longest_step(NAME) == trace.longest_step


def test_difference_is_as_silent_as_its_quieter_trace() -> None:
    source = TimedSource()
    made = recording(source, NAME)
    source.receive("/a", [1000.0, 1003.0], [1.0, 2.0])
    made.update()
    trace = made.trace(NAME)
    assert trace is not None and trace.span is None and trace.silence(1010.0) is None
    source.receive("/b", [1001.0], [1.0])
    made.update()
    assert trace.silence(1010.0) == pytest.approx(9.0)


def test_operands_are_kept_while_a_page_is_paused() -> None:
    source = TimedSource()
    made = recording(source, NAME, "/b/data")
    times = [1000.0 + 0.1 * index for index in range(100)]
    source.receive("/a", times, times)
    source.receive("/b", [time + 0.05 for time in times], [0.0] * 100)
    source.time = 1010.0
    made.update()
    expected = [part.tolist() for part in made.samples(NAME, 1002.0, 1003.0)]
    assert len(expected[0]) > 8 and not math.isnan(sum(expected[1]))
    made.pin({NAME: (1002.0, 1003.0), "/b/data": (1002.5, 1004.0)})
    late = [time + 100.0 for time in times]
    for topic in ("/a", "/b"):
        source.receive(topic, late, late)
    source.time = 1110.0
    made.update()
    assert [part.tolist() for part in made.samples(NAME, 1002.0, 1003.0)] == expected
    assert len(made.samples("/b/data", 1003.5, 1004.0)[0]) > 3
    assert made.samples(NAME, 1005.0, 1006.0)[0].tolist() == []


moments = st.lists(st.floats(0.0, 3.0), max_size=30).map(sorted)
#: With one period, because the gap limit depends on it.
regular = st.tuples(st.floats(0.0, 1.0), st.floats(0.02, 0.5)).map(
    lambda pair: [pair[0] + pair[1] * index for index in range(int(3.0 / pair[1]))]
)


def numbers(row: List[Any]) -> List[Any]:
    """Return the numbers of a bin, without its markers for missing values."""
    return [str(value) if value is None or value is False else value for value in row]


#: Formulas that look back, ahead, and at other traces.
names = st.sampled_from(
    [
        NAME,
        "=/a/data - delay(/b/data, 0.3)",
        "=delay(/b/data, -0.3) * 2",
        "=/b/data - mean(delay(/b/data, -0.2), 0.4)",
        "=/a/data + derivative(/b/data)",
    ]
)


@given(names, moments, regular, st.lists(st.floats(0.0, 3.5), max_size=8), st.booleans())
@settings(max_examples=30, deadline=None)
def test_frames_add_up_whichever_comes_late(
    name: str, first: List[float], second: List[float], looks: List[float], is_forgotten: bool
) -> None:
    source, times = TimedSource(), {"/a": first, "/b": second}
    made = recording(source, name)
    view, bins = LiveView(View(4.0, 100, None)), {}  # type: ignore[var-annotated]
    view.select([name])
    sent: Dict[str, int] = {"/a": 0, "/b": 0}
    for moment in sorted({*looks, 4.0}):
        source.time = 1000.0 + moment
        for topic, delay in (("/a", 0.0), ("/b", 0.7)):
            there = sum(time + delay <= moment for time in times[topic])
            new = times[topic][sent[topic] : there]
            if new:
                source.receive(topic, [1000.0 + time for time in new], [3.0 * time for time in new])
            sent[topic] = there
        made.update()
        frame = view.frame(source.time, made.samples, made.changed_since)
        if frame is None:
            continue
        if frame["reset"]:
            bins.clear()
        values = frame["traces"][name]
        for index in range(len(values) // 2):
            bins[frame["first"] + index] = values[2 * index : 2 * index + 2]
    whole = LiveView(View(4.0, 100, None))
    whole.select([name])
    last = whole.frame(source.time, made.samples, made.changed_since)
    assert last is not None
    for index in range(len(last["traces"][name]) // 2):
        expected = last["traces"][name][2 * index : 2 * index + 2]
        # A mean over other samples has other rounding errors.
        assert numbers(bins[last["first"] + index]) == pytest.approx(numbers(expected))
    if is_forgotten:
        made.forget()
        assert not numpy.size(made.samples(name, 0.0, 1e9))


@pytest.mark.parametrize("name", ["/a/data.derivative", "=derivative(/a/data)"])
def test_derivative_is_in_the_middle_and_explains_its_jumps(name: str) -> None:
    source = TimedSource()
    made = recording(source, name, "/a/data")
    source.receive("/a", [1.0, 1.5, 1.75, 9.0, 9.5], [0.0, 1.0, 2.0, 0.0, 4.0])
    source.time = 10.0
    made.update()
    times, values = made.samples(name, 0.0, 10.0)
    assert times.tolist() == [1.25, 1.625, 5.375, 9.25]
    assert values.tolist()[:2] + values.tolist()[3:] == [2.0, 4.0, 8.0]
    trace, plain = made.trace(name), made.trace("/a/data")
    assert trace is not None and plain is not None
    assert trace.jumps is not None and trace.jumps.startswith("timed by reception")
    assert plain.jumps is None


def test_endless_brackets_are_rejected_quickly() -> None:
    """A name in a request may be any text."""
    code = "from topic_scope.protocol.checks import fields_of; fields_of(['/a' + '[a]' * 60])"
    done = subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE, timeout=60)
    assert done.returncode == 0, done.stderr
