"""Messages of a played bag and their times, by the test's own clock."""

import contextlib
from pathlib import Path
from typing import Callable, Dict, Iterator, List, Tuple

import genpy
import pytest
import rosbag
from bags import BEGIN
from hypothesis import given, settings
from hypothesis import strategies as st
from std_msgs.msg import Int32

from topic_scope.bag.player import BagPlayer
from topic_scope.bag.ros1_recording import Ros1Recording

#: Recording times of each topic's messages after the start [ms].
RECORDED = {"/a": range(0, 10001, 100), "/b": range(50, 10000, 500)}
START = BEGIN / 1e9


class Clock:
    """Clock that is advanced manually, and by a step at each reading.

    :param step: the step [s]
    """

    def __init__(self, step: float = 0.0) -> None:
        self.time, self.step = 50.0, step

    def __call__(self) -> float:
        self.time += self.step
        return self.time


@pytest.fixture(scope="module")
def bag(tmp_path_factory: "pytest.TempPathFactory") -> Iterator[Ros1Recording]:
    path = str(tmp_path_factory.mktemp("bags") / "x.bag")
    reply = sorted((time, topic) for topic, times in RECORDED.items() for time in times)
    with rosbag.Bag(path, "w", chunk_threshold=500) as file:
        for time, topic in reply:
            file.write(topic, Int32(time), genpy.Time(0, BEGIN + time * 10**6))
    with Ros1Recording(path) as made:
        yield made


@pytest.fixture
def opened() -> Iterator[Callable[[Path], Ros1Recording]]:
    """Open bags, and close them after the test."""
    with contextlib.ExitStack() as stack:
        yield lambda path: stack.enter_context(Ros1Recording(str(path)))


def test_large_messages_are_read_in_several_calls(
    bag: Ros1Recording, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    player = playing(bag, Clock(), "/a", history=10.0)
    player.seek(player.end)
    player.now()
    assert not player.is_loading
    monkeypatch.setattr("topic_scope.bag.player.MOST_BYTES", 40)
    player.seek(player.end)
    counts = []
    while player.is_loading:
        player.now()
        counts.append(sum(len(one.messages) for one in player.subscriptions()["/a"].drain()))
    assert sum(counts) == len(RECORDED["/a"]) and len(counts) > 5


def playing(bag: Ros1Recording, clock: Clock, *topics: str, history: float = 3.0) -> BagPlayer:
    player = BagPlayer(bag, history, clock)
    player.want(topics)
    player.seek(START)
    return player


def taken(player: BagPlayer) -> Dict[str, List[int]]:
    """Return the output messages by topic, after checking their times."""
    found: Dict[str, List[int]] = {}
    for topic, subscription in player.subscriptions().items():
        for batch in subscription.drain():
            assert batch.header["type"] == "std_msgs/Int32"
            values = [int.from_bytes(message, "little") for message in batch.messages]
            expected = [START + value / 1e3 for value in values]
            assert [time / 1e9 for time in batch.times] == pytest.approx(expected, abs=1e-6)
            found.setdefault(topic, []).extend(values)
    return found


def loaded(player: BagPlayer) -> float:
    for _ in range(1000):
        now = player.now()
        if not player.is_loading:
            return now
    raise AssertionError("it loads for ever")


def expected(topics: Tuple[str, ...], above: float, up_to: float) -> Dict[str, List[int]]:
    """Return the messages recorded in a time span [ms]."""
    found = {topic: [time for time in RECORDED[topic] if above < time <= up_to] for topic in topics}
    return {topic: times for topic, times in found.items() if times}


#: Steps of 50 ms with an offset, so that no message is at the edge of the played span.
steps = st.lists(
    st.tuples(st.sampled_from(["wait", "play", "pause", "seek", "speed"]), st.integers(0, 80)),
    max_size=12,
)


@settings(max_examples=30)
@given(steps, st.sampled_from([0.0, 1e-3]))
def test_player_outputs_messages_up_to_the_clock(
    bag: Ros1Recording, steps: List[Tuple[str, int]], step: float
) -> None:
    clock = Clock()
    player = playing(bag, clock, "/a", "/b")
    player.seek(START + 0.025)
    at, speed, plays, before = 25.0, 1.0, False, -1.0  # the times in ms
    for kind, number in [("pause", 0), *steps]:
        if kind == "wait":
            clock.time += number * 0.05
            at = min(at + plays * number * 50.0 * speed, 10000.0)
        elif kind == "play" and at < 10000.0:
            player.play()
            plays = True
        elif kind == "pause":
            player.pause()
            plays = False
        elif kind == "seek":
            at = 25.0 + number * 50.0
            player.seek(START + at / 1e3)
            before = max(at - 3000.0, 0.0) - 1.0
        elif kind == "speed":
            player.speed = speed = 1.0 + number % 5
        clock.step = step if kind == "seek" else 0.0
        assert loaded(player) == pytest.approx(START + at / 1e3, abs=1e-6)
        assert taken(player) == expected(("/a", "/b"), before, at)
        clock.step = 0.0
        plays = plays and at < 10000.0
        assert player.is_playing == plays
        before = at


def test_messages_of_equal_times_get_distinct_times(
    tmp_path: Path, opened: Callable[[Path], Ros1Recording]
) -> None:
    """As in simulated time: every 10 ms, with many messages of each publisher."""
    path, count = tmp_path / "x.bag", 0
    connections: List[Dict[str, object]] = [{}, {}]  # one per publisher, as by rosbag record
    with rosbag.Bag(str(path), "w", chunk_threshold=2000) as file:
        for index in range(400):
            for file._topic_connections in connections:
                stamp = genpy.Time(0, BEGIN + index // 10 * 10**7)
                file.write("/a", Int32(count), stamp)
                count += 1
    clock = Clock()
    bag = opened(path)
    assert len(bag.connections) == 2
    player = playing(bag, clock, "/a")
    loaded(player)
    player.play()
    output: List[Tuple[float, int]] = []
    for _ in range(45):
        clock.time += 0.01
        player.now()
        for batch in player.subscriptions()["/a"].drain():
            values = [int.from_bytes(message, "little") for message in batch.messages]
            output += zip((time / 1e9 for time in batch.times), values)
            assert list(batch.times) == sorted(batch.times)
    assert sorted(value for _, value in output) == list(range(count))
    assert len({time for time, _ in output}) == count
    for time, value in output:
        assert time == pytest.approx(START + value // 20 * 0.01, abs=1.5e-5)


def test_times_of_successive_outputs_are_distinct(
    tmp_path: Path, opened: Callable[[Path], Ros1Recording]
) -> None:
    path, clock = tmp_path / "x.bag", Clock()
    with rosbag.Bag(str(path), "w") as file:
        for time in (0, 0, 400, 10**7):  # ns; the second is output after the recording of the third
            file.write("/a", Int32(), genpy.Time(0, BEGIN + time))
    player = playing(opened(path), clock, "/a")
    loaded(player)
    player.play()
    batches = list(player.subscriptions()["/a"].drain())
    assert len(batches[0].messages) == 2
    clock.time += 1.0
    player.now()
    batches += player.subscriptions()["/a"].drain()
    times = [time for batch in batches for time in batch.times]
    assert times == sorted(set(times)) and len(times) == 4


def test_latest_output_of_two_publishers_counts(
    tmp_path: Path, opened: Callable[[Path], Ros1Recording]
) -> None:
    path, clock = tmp_path / "x.bag", Clock()
    with rosbag.Bag(str(path), "w") as file:
        for topic, time in (("/a", 0), ("a", 0), ("a", 0), ("/a", 400)):  # ns
            file.write(topic, Int32(), genpy.Time(0, BEGIN + time))
    player = playing(opened(path), clock, "/a")
    loaded(player)
    player.play()
    clock.time += 1.0
    player.now()
    times = [time for one in player.subscriptions()["/a"].drain() for time in one.times]
    assert len(set(times)) == 4


def test_only_requested_topics_are_output_and_more_after_a_seek(bag: Ros1Recording) -> None:
    player = playing(bag, Clock(), "/b", "/not/there")
    player.seek(START + 1.05)
    loaded(player)
    assert taken(player) == {"/b": [50, 550]}
    assert not player.lacks_past
    player.want(["/a", "/b"], True)
    player.want(["/a", "/b"])
    assert player.lacks_past
    player.seek(START + 1.05)
    loaded(player)
    assert not player.lacks_past
    assert taken(player)["/a"] == list(range(0, 1001, 100))


def test_it_stops_at_the_end(bag: Ros1Recording) -> None:
    clock = Clock()
    player = playing(bag, clock, "/a")
    player.seek(START + 9.95)
    player.play()
    loaded(player)
    clock.time += 1.0
    assert player.now() == player.end == pytest.approx(START + 10.0, abs=1e-6)
    assert not player.is_playing
    player.play()
    clock.time += 1.0
    assert player.now() == player.place == player.end
    assert not player.is_playing


def test_places_beyond_its_ends_are_its_ends(bag: Ros1Recording) -> None:
    player = playing(bag, Clock(), "/a")
    for place, there in ((0.0, player.start), (1e11, player.end)):
        player.seek(place)
        assert loaded(player) == there


def test_reading_time_of_a_call_is_limited_and_the_clock_waits(bag: Ros1Recording) -> None:
    clock = Clock(step=1.0)  # so that each look reads one chunk
    player = playing(bag, clock, "/a", history=60.0)
    player.seek(START + 10.1)
    seen, looks = [], 0
    while player.is_loading:
        now, looks = player.now(), looks + 1
        found = taken(player).get("/a", [])
        assert all(START + value / 1e3 <= now + 1e-6 for value in found)
        seen += found
    assert seen == list(RECORDED["/a"]) and looks > 3
    player.seek(player.start)
    player.play()
    looks = 0
    while player.is_playing:
        player.now()
        looks += 1
    assert taken(player) == {"/a": list(RECORDED["/a"])} and looks > 3


def test_last_chunk_is_read_even_if_it_begins_at_the_end(
    tmp_path: Path, opened: Callable[[Path], Ros1Recording]
) -> None:
    path = tmp_path / "x.bag"
    with rosbag.Bag(str(path), "w", chunk_threshold=1) as file:
        for time in (0, 1000):
            file.write("/a", Int32(time), genpy.Time(0, BEGIN + time * 10**6))
    player = playing(opened(path), Clock(step=1.0), "/a")
    player.seek(player.end)
    loaded(player)
    assert taken(player) == {"/a": [0, 1000]}


def test_player_does_not_catch_up_after_a_delay(bag: Ros1Recording) -> None:
    clock = Clock()
    player = playing(bag, clock, "/a")
    loaded(player)
    player.play()
    clock.step = 5.0
    late = player.now() - START
    clock.step = 0.0
    assert late < 5.0
    clock.time += 0.1
    assert player.now() - START == pytest.approx(late + 0.1, abs=1e-6)


def test_change_of_speed_keeps_the_position(bag: Ros1Recording) -> None:
    clock = Clock()
    player = playing(bag, clock, "/a")
    loaded(player)
    player.play()
    clock.time += 1.0
    player.speed = 2.0
    clock.time += 1.0
    player.pause()
    clock.time += 1.0
    assert player.now() - START == pytest.approx(3.0, abs=1e-6)


def test_damaged_chunk_is_reported_and_others_are_output(
    tmp_path: Path, opened: Callable[[Path], Ros1Recording]
) -> None:
    path = tmp_path / "x.bag"
    with rosbag.Bag(str(path), "w", chunk_threshold=200, compression="bz2") as file:
        for number in range(20):
            file.write("/a", Int32(number * 1000), genpy.Time(0, BEGIN + number * 10**9))
    content = bytearray(path.read_bytes())
    content[content.index(b"BZh") + 20] ^= 0xFF
    path.write_bytes(content)
    player = playing(opened(path), Clock(), "/a", history=60.0)
    player.seek(START + 20.0)
    loaded(player)
    found = taken(player)["/a"]
    assert 0 not in found and found == list(range(found[0], 20000, 1000))
    assert "damaged" in player.problems[0] and str(path) in player.problems[0]


def test_side_subscriptions_get_the_latest_message_however_old(
    tmp_path: Path, opened: Callable[[Path], Ros1Recording]
) -> None:
    path = tmp_path / "x.bag"
    with rosbag.Bag(str(path), "w", chunk_threshold=200) as file:
        for time in range(0, 10001, 100):
            if time in (0, 1000, 9000):
                file.write("/rare", Int32(time), genpy.Time(0, BEGIN + time * 10**6))
            file.write("/a", Int32(time), genpy.Time(0, BEGIN + time * 10**6))
    player = playing(opened(path), Clock(), "/a", "/rare", history=1.0)
    player.aside.want(["/rare"])
    assert player.lacks_past
    player.seek(START + 8.05)
    loaded(player)
    assert taken(player) == {"/a": list(range(7100, 8001, 100))}
    besides = list(player.aside.subscriptions()["/rare"].drain())
    values = [int.from_bytes(one, "little") for batch in besides for one in batch.messages]
    assert values == [1000] and besides[-1].times[-1] / 1e9 == pytest.approx(START + 1.0, abs=1e-5)
    # Other topics have the last seconds, and then the messages up to the clock.
    longer = BagPlayer(opened(path), 60.0, Clock())
    longer.aside.want(["/a"])
    longer.seek(START + 8.05)
    loaded(longer)
    besides = list(longer.aside.subscriptions()["/a"].drain())
    values = [int.from_bytes(one, "little") for batch in besides for one in batch.messages]
    assert values[-50:] == list(range(3100, 8001, 100)) and len(values) < 80
    # A topic that is no longer requested is dropped, and may be requested again.
    player.aside.want([])
    assert (player.aside.subscriptions(), player.lacks_past) == ({}, False)
    player.aside.want(["/rare"])
    assert player.lacks_past


def test_note_about_a_message_is_reported_once(bag: Ros1Recording) -> None:
    player = playing(bag, Clock(), "/a", history=10.0)
    bag.notes.append("a message is left out")
    player.seek(player.end)
    while player.is_loading:
        player.now()
    assert list(player.problems) == ["a message is left out"] and bag.notes == []
