"""Statistics printed on the terminal for the named fields."""

import struct
from typing import List, Optional, Tuple

import pytest
from bags import nanoseconds
from std_msgs.msg import Float32
from test_recorder import FakeSource, header, recording

from topic_scope.page.frequency_backoff import FrequencyBackoff
from topic_scope.page.statistics_table import statistics_of, warn_of
from topic_scope.page.view import LiveView
from topic_scope.protocol.requests import Measure, View
from topic_scope.sampling.message_source import Batch


@pytest.mark.parametrize(
    "span, words",
    [
        ((1000.0, 1004.0), None),
        ((1013.0, 1015.0), "no sample in this span: the latest is 3 s before it"),
        ((1005.5, 1006.5), "no sample in this span of 1 s: show a longer one"),
        ((990.0, 992.5), "no sample in this span: the first is 7.5 s after it"),
    ],
)
def test_trace_without_a_sample_in_the_span_has_a_reason(
    span: Tuple[float, float], words: Optional[str]
) -> None:
    """One message per 5 s, or stamps later than the window."""
    source = FakeSource()
    made = recording(source, "/a/data")
    times = [1000.0, 1005.0, 1010.0]
    data = [struct.pack("<f", 1.0)] * 3
    source.topics["/a"].batches.append(Batch(header(Float32), nanoseconds(times), data))
    source.time = 1010.5
    made.update()
    start, end = span
    view = LiveView(View(end - start, 100, end))
    view.select(["/a/data"])
    reply = statistics_of(made, made.samples, view, Measure(), FrequencyBackoff(), source.time)[
        "traces"
    ]["/a/data"]
    assert (reply["problem"], reply["silent"]) == (words, None)


def test_jumps_of_a_derivative_by_reception_are_explained() -> None:
    source, names = FakeSource(), ["/a/data", "/a/data.derivative"]
    made = recording(source, *names)
    source.send(Float32, 1.0, 2.0, 4.0)
    made.update()
    view = LiveView(View(5.0, 100, None))
    view.select(names)
    table = statistics_of(made, made.samples, view, Measure(), FrequencyBackoff(), source.time)
    plain, derivative = (table["traces"][name]["jumps"] for name in names)
    assert plain is None and derivative.startswith("timed by reception")


def test_trace_is_silent_only_for_longer_than_usual() -> None:
    source = FakeSource()
    made = recording(source, "/a/data")
    for _ in range(5):
        source.send(Float32, 1.0)
        source.time += 1.0
        made.update()
    view = LiveView(View(5.0, 100, None))
    view.select(["/a/data"])
    found = []
    for later in (3.0, 40.0):
        now = source.time + later
        table = statistics_of(made, made.samples, view, Measure(), FrequencyBackoff(), now)
        found.append(table["traces"]["/a/data"]["silent"])
    assert found == [None, pytest.approx(42.0)]


class Recorder:
    """Recorder with a problem of one field."""

    def problem(self, name: str) -> Optional[str]:
        return "the topic does not exist yet" if name == "/b" else None


def test_problems_and_omitted_traces_are_logged(monkeypatch: "pytest.MonkeyPatch") -> None:
    said: List[str] = []
    monkeypatch.setattr("rospy.logwarn", said.append)
    recorder: "Recorder" = Recorder()
    warn_of(recorder, ["/a", "/b"], 2)  # type: ignore[arg-type]
    assert said == ["/b: the topic does not exist yet"]
    said.clear()
    warn_of(recorder, ["/a", "/a", "/b"], 2)  # type: ignore[arg-type]
    assert said == ["a page shows at most 2 traces: the rest of 3 are left out"]
