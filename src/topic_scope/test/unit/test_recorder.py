"""Recorded samples and their lifetime, with a fake message source."""

import asyncio
import io
import math
import struct
from typing import Collection, Dict, Iterator, List

import numpy
import pytest
from bags import nanoseconds, serialized
from sensor_msgs.msg import JointState
from std_msgs.msg import Float32, Float64, Float64MultiArray

from topic_scope.messages.layout_cache import Layouts
from topic_scope.page.csv_export import parts
from topic_scope.sampling import recorder
from topic_scope.sampling.message_source import Batch
from topic_scope.sampling.recorder import Recorder

TYPES = {"/a": "std_msgs/Float32", "/b": "std_msgs/Float64MultiArray", "/c": "nowhere/Thing"}


def header(message_class: type) -> Dict[str, str]:
    """Return the connection header of a publisher."""
    return {
        "type": message_class._type,  # type: ignore[attr-defined]
        "md5sum": message_class._md5sum,  # type: ignore[attr-defined]
        "message_definition": message_class._full_text,  # type: ignore[attr-defined]
    }


class FakeSubscription:
    """One topic."""

    def __init__(self) -> None:
        self.batches: List[Batch] = []

    def drain(self) -> Iterator[Batch]:
        batches, self.batches = self.batches, []
        return iter(batches)


class FakeSource:
    """All topics, and the clock."""

    def __init__(self) -> None:
        self.time = 1000.0
        self.wanted: List[str] = []
        self.topics = {topic: FakeSubscription() for topic in TYPES}

    @property
    def clock(self) -> "FakeSource":
        return self

    def now(self) -> float:
        return self.time

    @property
    def has_ended(self) -> bool:
        return False

    def want(self, topics: Collection[str], is_more: bool) -> None:
        self.wanted, self.is_more = sorted(topics), is_more

    def subscriptions(self) -> Dict[str, FakeSubscription]:
        return self.topics

    def send(self, message_class: type, *values: float) -> None:
        code = "<f" if message_class is Float32 else "<d"
        times = nanoseconds(self.time + 0.01 * index for index in range(len(values)))
        data = [struct.pack(code, value) for value in values]
        self.topics["/a"].batches.append(Batch(header(message_class), times, data))
        self.time += 1.0


def recording(source: FakeSource, *names: str) -> Recorder:
    made = Recorder(source, Layouts(), 10.0)  # type: ignore[arg-type]
    made.set_topics(TYPES)
    made.want(names, source.time)
    return made


def values(made: Recorder, name: str = "/a/data") -> List[float]:
    return list(made.samples(name, 0.0, 1e9)[1])


def test_topic_with_an_unreadable_definition_has_no_fields_of_the_installed_type() -> None:
    layouts = Layouts()
    layouts.installed("std_msgs/Float32")
    layouts.reject({"type": "std_msgs/Float32"}, "its definition cannot be read")
    made = Recorder(FakeSource(), layouts, 10.0)  # type: ignore[arg-type]
    made.set_topics({"/a": "std_msgs/Float32"})
    made.want(["/a/data"], 1000.0)
    assert made.choices() == []
    assert made.problem("/a/data") == "its definition cannot be read"


def test_definition_of_one_publisher_does_not_replace_the_installed_type() -> None:
    layouts = Layouts()
    installed = layouts.installed("std_msgs/Float32")
    other = {"type": "std_msgs/Float32", "md5sum": "1", "message_definition": "float64 other"}
    assert layouts.received(other) is not installed
    assert layouts.installed("std_msgs/Float32") is installed
    assert layouts.received({**other, "type": "not_here/Type"}) is layouts.installed(
        "not_here/Type"
    )


def test_only_requested_fields_are_subscribed_and_recorded() -> None:
    source = FakeSource()
    made = recording(source, "/a/data", "/d/later")
    assert source.wanted == ["/a", "/c"] and source.is_more  # the latter to learn its type
    made.want(["/a/data", "/d/later"], source.time)
    assert not source.is_more
    source.send(Float32, 1.0, 2.0)
    assert made.update() == 1001.0
    assert values(made) == [1.0, 2.0]
    assert values(made, "/d/later") == [] and made.trace("/d/later") is None
    assert made.trace("/a/data").stream.topic == "/a"  # type: ignore[union-attr]
    made.want(["/a/data@received"], source.time)  # it starts with the latest message
    assert values(made, "/a/data@received") == [2.0]


def test_latest_message_is_forgotten_with_its_subscription() -> None:
    source = FakeSource()
    made = recording(source, "/a/data")
    source.send(Float32, 1.0)
    made.update()
    made.want([], source.time + 11.0)
    closed = source.topics.pop("/a")
    made.update()
    source.topics["/a"] = closed
    made.want(["/a/data"], source.time + 12.0)
    assert values(made) == []


def test_fields_of_a_recorded_array_are_listed_as_it_grows() -> None:
    source = FakeSource()
    made = recording(source, "/b/data[0]")
    for count in (1, 3):
        data = [serialized(Float64MultiArray(data=[0.5] * count))]
        batch = Batch(header(Float64MultiArray), nanoseconds([source.time]), data)
        source.topics["/b"].batches.append(batch)
        source.time += 1.0
        made.update()
        listed = [choice.field for choice in made.choices() if choice.topic == "/b"]
        assert [name for name in listed if "data[" in name] == [
            f"/b/data[{index}]" for index in range(count)
        ]


def test_a_type_that_changes_is_read_by_its_own_definition() -> None:
    source = FakeSource()
    made = recording(source, "/a/data")
    source.send(Float32, 1.0)
    source.send(Float64, 0.1)
    source.send(Float32, 3.0)
    made.update()
    assert values(made) == [1.0, 0.1, 3.0]


def test_unrequested_field_is_kept_for_the_history() -> None:
    source = FakeSource()
    made = recording(source, "/a/data")
    source.send(Float32, 1.0)
    made.update()
    made.want([], 1009.0)
    assert values(made) == [1.0]
    made.want([], 1011.0)
    assert values(made) == [] and source.wanted == ["/c"]


def test_mean_needs_all_of_its_samples() -> None:
    source = FakeSource()
    made = recording(source, "=mean(/a/data, 2)", "=mean(/a/data, 15)")
    for second in range(30):
        source.send(Float32, *(second + 0.01 * index for index in range(100)))
        made.update()
        times, means = made.samples("=mean(/a/data, 2)", -math.inf, math.inf)
        # A ramp of 1/s from 1000 s on: the mean of the last two seconds is the value 1 s ago.
        late = times > 1002.0
        assert means[late] == pytest.approx(times[late] - 1000.995, abs=0.01)
    assert times[0] == pytest.approx(1021.99, abs=0.05)  # of ten seconds that are kept
    assert made.problem("=mean(/a/data, 2)") is None
    problem = made.problem("=mean(/a/data, 15)")
    assert problem == "it needs the last 15 s, and samples are kept for 10 s (--history)"
    assert not len(made.samples("=mean(/a/data, 15)", -math.inf, math.inf)[0])


def test_look_ahead_needs_samples_on_both_sides() -> None:
    source = FakeSource()
    around = {name: f"=highest(/a/data, {name})" for name in (4, 6)}
    made = recording(source, *around.values(), "=delay(/a/data, -11)")
    for second in range(30):
        source.send(Float32, *(second + 0.01 * index for index in range(100)))
        made.update()
    times, _ = made.samples(around[4], -math.inf, math.inf)
    assert times[0] == pytest.approx(1024.24, abs=0.02) and times[-1] == pytest.approx(1025.99)
    assert made.problem(around[4]) is None
    assert not len(made.samples(around[6], -math.inf, math.inf)[0])
    assert made.problem(around[6]) == (
        "it needs 6.25 s before and 6 s after each, and samples are kept for 10 s (--history)"
    )
    problem = made.problem("=delay(/a/data, -11)")
    assert problem and problem.startswith("it needs 0 s before and 11 s after each, and")


def test_late_sample_changes_earlier_values_of_a_formula_that_looks_ahead() -> None:
    source = FakeSource()
    made = recording(source, "=delay(/a/data, -2)")
    for second in range(10):
        source.send(Float32, second)
        seen = made.update()
    late = nanoseconds([1005.5])
    source.topics["/a"].batches.append(Batch(header(Float32), late, [struct.pack("<f", 7.0)]))
    source.time += 0.1
    made.update()
    assert made.changed_since(seen) == pytest.approx(1003.5)


def test_csv_has_what_has_arrived_until_now() -> None:
    source = FakeSource()
    made = recording(source, "/a/data")
    source.send(Float32, 1.0)

    async def text() -> str:
        return "".join([part async for part in parts(made, ["/a/data"], 0.0, 1e9)])

    assert asyncio.run(text()).splitlines()[1:] == ["1000.000000000,1000.000000000,1.0"]


def test_fields_stay_requested_after_a_reset() -> None:
    source = FakeSource()
    made = recording(source, "/a/data")
    source.send(Float32, 1.0, 2.0)
    made.update()
    made.forget()
    source.time -= 500.0  # earlier than all existing samples
    source.send(Float32, 3.0)
    source.time += 1.0
    before = made.update()
    assert values(made) == [3.0]
    source.send(Float32, 4.0)
    assert made.update() == made.updated == source.time
    assert made.changed_since(before) == before


def test_formula_that_looks_ahead_is_sent_again_after_a_reset() -> None:
    source = FakeSource()
    made = recording(source, "=delay(/a/data, -2)")
    for _ in range(5):
        source.send(Float32, 1.0)
        made.update()
    made.forget()
    source.time = 500.0
    for _ in range(4):
        source.send(Float32, 1.0)
        before = made.update()
    source.send(Float32, 1.0)
    made.update()
    assert made.changed_since(before) == 501.0  # known up to there before


def test_page_that_has_missed_too_many_updates_gets_everything() -> None:
    source = FakeSource()
    made = recording(source, "/a/data")
    seen = made.update()
    source.time += 1.0
    made.update()
    assert made.changed_since(seen) == seen
    for _ in range(400):
        source.time += 0.025
        made.update()
    assert made.changed_since(seen) == -math.inf


def test_the_number_of_traces_is_limited() -> None:
    source = FakeSource()
    made = recording(source)
    for index in range(recorder.TRACES + 100):
        made.want(["/a/data", f"/b/data[{index}]"], source.time + index * 1e-3)
    assert len(made._traces) == recorder.TRACES
    assert made.trace("/a/data") and made.trace(f"/b/data[{recorder.TRACES + 99}]")
    assert not made.trace("/b/data[0]")


def test_shown_traces_are_not_dropped_for_others() -> None:
    source = FakeSource()
    made = recording(source)
    names = [f"/b/data[{index}]" for index in range(recorder.TRACES)]
    made.want(names, source.time)
    made.want(["/a/data"] + names[1:], source.time + 1.0)
    assert len(made._traces) == recorder.TRACES
    assert made.trace("/a/data") and made.trace(names[1]) and not made.trace(names[0])


def test_the_number_of_fields_that_are_listed_is_limited() -> None:
    made = recording(FakeSource())
    count = recorder.LISTED + 10
    made.set_topics({f"/n{number:05}": "std_msgs/Float32" for number in range(count)})
    listed = made.choices()
    assert [choice.field for choice in (listed[0], listed[-1])] == [
        "/n00000/data",
        f"/n{recorder.LISTED - 1:05}/data",
    ]
    assert len(listed) == recorder.LISTED == 5000


def test_log_and_status_topics_are_listed_last() -> None:
    made = recording(FakeSource())
    types = ["rosgraph_msgs/Log", "rosgraph_msgs/TopicStatistics", "dynamic_reconfigure/Config"]
    topics = {f"/{number}": one for number, one in enumerate([*types, "std_msgs/Float32"])}
    made.set_topics(topics)
    order = list(dict.fromkeys(choice.topic for choice in made.choices()))
    assert order == ["/3", "/0", "/1", "/2"]


def test_number_of_topics_subscribed_for_their_type_is_limited() -> None:
    source = FakeSource()
    made = recording(source)
    made.set_topics({f"/n{number}": "nowhere/Thing" for number in range(100)})
    made.want(["/n99/x"], source.time)
    assert len(source.wanted) == recorder.UNKNOWN + 1 == 51
    assert "/n99" in source.wanted


def test_elements_are_listed_by_name_after_the_first_message() -> None:
    source = FakeSource()
    made = recording(source)
    made.set_topics({"/j": "sensor_msgs/JointState"})
    made.want([], source.time)
    assert source.wanted == ["/j"]
    before = [choice.field for choice in made.choices()]
    assert "/j/position[0]" in before and "/j/position[arm]" not in before
    buffer = io.BytesIO()
    JointState(name=["leg", "arm"], position=[1.0, 2.0]).serialize(buffer)
    source.topics["/j"] = FakeSubscription()
    source.topics["/j"].batches.append(
        Batch(header(JointState), nanoseconds([source.time]), [buffer.getvalue()])
    )
    made.update()
    after = {choice.field: choice.topic for choice in made.choices()}
    assert after["/j/position[leg]"] == after["/j/position[arm]"] == "/j"
    made.want([], source.time)
    assert source.wanted == []
    # A name for several elements expands to these names; an index stays an index.
    assert made.expand("/j/position") == ["/j/position[leg]", "/j/position[arm]"]
    assert made.expand("/j/position[1]@stamp") == ["/j/position[1]@stamp"]
    # It is recorded under the listed name, and starts with the received message: of a latched
    # topic no other may arrive.
    made.want(["/j/position[arm]"], source.time)
    assert values(made, "/j/position[arm]") == [2.0]
    made.want(["/j/position[leg]"], source.time)
    assert values(made, "/j/position[leg]") == [1.0]
    source.topics["/j"].batches.append(
        Batch(header(JointState), nanoseconds([source.time + 1]), [buffer.getvalue()])
    )
    made.update()
    assert values(made, "/j/position[arm]") == [2.0, 2.0]


def test_joints_of_two_publishers_have_whole_lines() -> None:
    """Each message has only the joints of its publisher, in its own order."""
    source = FakeSource()
    source.topics["/j"] = FakeSubscription()
    made = recording(source)
    made.set_topics({"/j": "sensor_msgs/JointState"})

    def publish(index: int, **positions: float) -> None:
        buffer = io.BytesIO()
        message = JointState(name=list(positions), position=list(positions.values()))
        message.serialize(buffer)
        times = nanoseconds([source.time + 0.01 * index])
        source.topics["/j"].batches.append(Batch(header(JointState), times, [buffer.getvalue()]))

    publish(0, arm=0.0, both=-1.0)
    publish(1, both=-1.0, leg=0.0)
    made.update()
    names = [f"/j/position[{name}]" for name in ("arm", "both", "leg")]
    assert sorted(made.expand("/j/position")) == names
    made.want(names, source.time)
    for index in range(2, 40, 2):
        publish(index, arm=float(index), both=-1.0)
        publish(index + 1, both=-1.0, leg=math.nan if index == 30 else float(index))
        made.update()
        assert [made.problem(name) for name in names] == [None] * 3
        listed = [choice.field for choice in made.choices()]
        assert sorted(name for name in listed if name.startswith("/j/position[")) == names
    assert values(made, names[0]) == [float(index) for index in range(2, 40, 2)]
    assert set(values(made, names[1])) == {-1.0} and len(values(made, names[1])) >= 38
    legs = values(made, names[2])
    assert legs[0] == 0.0 and len(legs) == 20  # it started with the received message
    assert math.isnan(legs[15]) and numpy.isfinite(legs).sum() == 19  # NaN is a gap
    assert made.longest_step(names[0]) > 0.02


def test_problems_of_fields_are_reported() -> None:
    source = FakeSource()
    names = ["/a/data", "/a/nothing", "/b/data[2]", "/b/data[3]", "/d/later", "/a/data.yaw"]
    made = recording(source, *names)
    data = [serialized(Float64MultiArray(data=values)) for values in ([1.0], [1.0, 2.0, 3.0])]
    times = nanoseconds([source.time, source.time + 0.1])
    batch = Batch(header(Float64MultiArray), times, data)
    source.topics["/b"].batches.append(batch)
    made.update()
    assert {name: made.problem(name) for name in names} == {
        "/a/data": None,
        "/a/nothing": "there is no nothing in std_msgs/Float32",
        "/b/data[2]": None,
        "/b/data[3]": "data has 3 elements now",
        "/d/later": "the topic does not exist yet",
        "/a/data.yaw": "there is no quaternion in data",
    }
    # Another type without the field.
    made.set_topics({**TYPES, "/a": "std_msgs/Empty", "/d": "std_msgs/Float32"})
    assert made.problem("/a/data") == "there is no data in std_msgs/Empty"
    assert made.problem("/d/later") == "there is no later in std_msgs/Float32"


def test_names_are_expanded_as_far_as_they_are_known() -> None:
    made = recording(FakeSource())
    assert made.expand("/a") == ["/a/data"]
    assert made.expand("/d/later") == ["/d/later"]
    assert made.expand("/c/x") == ["/c/x"]
    choices = [choice.field for choice in made.choices()]
    assert choices[0] == "/a/data" and "/b/data[0]" in choices
    made.set_topics({"/a": "dynamic_reconfigure/Config", **dict.fromkeys("bc", "std_msgs/Float32")})
    listed = list(dict.fromkeys(choice.topic for choice in made.choices()))
    assert listed == ["b", "c", "/a"]


def test_arrays_of_removed_topics_are_dropped() -> None:
    source = FakeSource()
    made = recording(source, "/a/data")
    source.send(Float32, 1.0)
    made.update()
    made.set_topics({})
    assert list(made._arrays) == ["/a"]  # it is recorded, and may reappear
    assert made.problem("/a/data") is None and values(made) == [1.0]
    made.want([], source.time + 100.0)
    made.set_topics({})
    assert not made._arrays
