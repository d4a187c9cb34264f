"""What is recorded, and for how long; messages come from taps that a test fills."""

import struct
from typing import Collection, Dict, Iterator, List

from std_msgs.msg import Float32, Float64

from topic_scope import recorder
from topic_scope.layouts import Layouts
from topic_scope.recorder import Recorder
from topic_scope.taps import Batch

TYPES = {"/a": "std_msgs/Float32", "/b": "std_msgs/Float64MultiArray", "/c": "nowhere/Thing"}


def header(message_class: type) -> Dict[str, str]:
    """Return what a publisher says of its messages."""
    return {
        "type": message_class._type,  # type: ignore[attr-defined]
        "md5sum": message_class._md5sum,  # type: ignore[attr-defined]
        "message_definition": message_class._full_text,  # type: ignore[attr-defined]
    }


class FakeTap:
    """One topic."""

    def __init__(self) -> None:
        self.batches: List[Batch] = []

    def take(self) -> Iterator[Batch]:
        batches, self.batches = self.batches, []
        return iter(batches)


class FakeTaps:
    """All topics, and the clock."""

    def __init__(self) -> None:
        self.time = 1000.0
        self.wanted: List[str] = []
        self.taps = {topic: FakeTap() for topic in TYPES}

    @property
    def clock(self) -> "FakeTaps":
        return self

    def now(self) -> float:
        return self.time

    def want(self, topics: Collection[str]) -> None:
        self.wanted = sorted(topics)

    def open(self) -> Dict[str, FakeTap]:
        return self.taps

    def send(self, message_class: type, *values: float) -> None:
        code = "<f" if message_class is Float32 else "<d"
        times = [self.time + 0.01 * index for index in range(len(values))]
        data = [struct.pack(code, value) for value in values]
        self.taps["/a"].batches.append(Batch(header(message_class), times, data))
        self.time += 1.0


def recording(taps: FakeTaps, *names: str) -> Recorder:
    made = Recorder(taps, Layouts(), 10.0)  # type: ignore[arg-type]
    made.set_topics(TYPES)
    made.want(names, taps.time)
    return made


def values(made: Recorder, name: str = "/a/data") -> List[float]:
    return list(made.samples(name, 0.0, 1e9)[1])


def test_records_what_is_wanted_and_listens_to_no_more() -> None:
    taps = FakeTaps()
    made = recording(taps, "/a/data", "/d/later")
    assert taps.wanted == ["/a", "/c"]  # the latter to learn its type
    taps.send(Float32, 1.0, 2.0)
    assert made.update() == 1001.0
    assert values(made) == [1.0, 2.0]
    assert values(made, "/d/later") == [] and made.topic_of("/d/later") == ""
    assert made.topic_of("/a/data") == "/a"


def test_a_type_that_changes_is_read_by_its_own_definition() -> None:
    taps = FakeTaps()
    made = recording(taps, "/a/data")
    taps.send(Float32, 1.0)
    taps.send(Float64, 0.1)
    taps.send(Float32, 3.0)
    made.update()
    assert values(made) == [1.0, 0.1, 3.0]


def test_what_nobody_wants_any_more_is_kept_for_the_history() -> None:
    taps = FakeTaps()
    made = recording(taps, "/a/data")
    taps.send(Float32, 1.0)
    made.update()
    made.want([], 1009.0)
    assert values(made) == [1.0]
    made.want([], 1011.0)
    assert values(made) == [] and taps.wanted == ["/c"]


def test_the_number_of_traces_is_limited() -> None:
    taps = FakeTaps()
    made = recording(taps)
    for index in range(recorder.TRACES + 100):
        made.want(["/a/data", "/b/data[%d]" % index], taps.time + index * 1e-3)
    assert len(made._traces) == recorder.TRACES
    assert made.topic_of("/a/data") and made.topic_of("/b/data[%d]" % (recorder.TRACES + 99))
    assert not made.topic_of("/b/data[0]")


def test_names_are_expanded_as_far_as_they_are_known() -> None:
    made = recording(FakeTaps())
    assert made.expand("/a") == ["/a/data"]
    assert made.expand("/d/later") == ["/d/later"]
    assert made.expand("/c/x") == ["/c/x"]
    choices = [choice.field for choice in made.choices()]
    assert choices[0] == "/a/data" and "/b/data[0]" in choices
