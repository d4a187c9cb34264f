"""Bag reader against rosbag, and errors of damaged bags."""

import struct
from pathlib import Path
from typing import Any, Dict, List, Optional, Set, Tuple
from unittest import mock

import genpy
import pytest
import rosbag
from bags import BEGIN, serialized, write_bag
from hypothesis import given, settings
from hypothesis import strategies as st
from std_msgs.msg import Float64, Int32, String

from topic_scope.bag.recording import BagError
from topic_scope.bag.message_slices import Slice, first_messages, slices
from topic_scope.bag.ros1_recording import Ros1Recording

#: Topic, length of the text, time; small chunks hold some of them each, out of order.
messages = st.lists(
    st.tuples(st.sampled_from("abc"), st.integers(0, 300), st.integers(0, 10**10)), min_size=1
)


def write(path: Path, sent: List[Tuple[str, int, int]], compression: str = "none") -> str:
    with rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=1000) as bag:
        for topic, length, time in sent:
            bag.write(topic, String("x" * length), genpy.Time(0, BEGIN + time))
    return str(path)


def read(bag: Ros1Recording, wanted: Set[str], after: int) -> List[Tuple[int, str, bytes]]:
    """Return time, topic and bytes of all messages of the chunks after a time."""
    numbers = {number for number, one in bag.connections.items() if one.topic in wanted}
    found = []
    for chunk, _ in zip(*bag.chunks_after(after)):
        for part in bag.read(chunk, numbers):
            topic = bag.connections[part.connection].topic
            found += [(time, topic, data) for time, data in zip(part.times.tolist(), part.messages)]
    return sorted(found)


def as_read_by_rosbag(path: str, wanted: Set[str]) -> List[Tuple[int, str, bytes]]:
    with rosbag.Bag(path) as bag:
        return sorted(
            (time.to_nsec(), "/" + topic, raw[1])
            for topic, raw, time in bag.read_messages(raw=True)
            if "/" + topic in wanted
        )


@settings(max_examples=30)
@given(
    messages, st.sets(st.sampled_from(["/a", "/b", "/c"])), st.sampled_from(["none", "bz2", "lz4"])
)
def test_all_messages_of_requested_topics_are_read(
    tmp_path_factory: "pytest.TempPathFactory",
    sent: List[Tuple[str, int, int]],
    wanted: Set[str],
    compression: str,
) -> None:
    path = write(tmp_path_factory.mktemp("bags") / "x.bag", sent, compression)
    bag = Ros1Recording(path)
    assert read(bag, wanted, 0) == as_read_by_rosbag(path, wanted)
    assert (bag.start, bag.end) == tuple(
        BEGIN + end(time for _, _, time in sent) for end in (min, max)
    )
    bag.close()


@settings(max_examples=30)
@given(messages, st.integers(0, 10**10))
def test_earlier_chunks_are_skipped_and_others_sorted(
    tmp_path_factory: "pytest.TempPathFactory", sent: List[Tuple[str, int, int]], after: int
) -> None:
    bag = Ros1Recording(write(tmp_path_factory.mktemp("bags") / "x.bag", sent))
    numbers, starts = bag.chunks_after(BEGIN + after)
    assert starts == sorted(starts)
    expected = [time for _, _, time in sent if time > after]
    found = [time for time, *_ in read(bag, {"/a", "/b", "/c"}, BEGIN + after)]
    assert sorted(BEGIN + time for time in expected) == [t for t in found if t > BEGIN + after]
    for number, start in zip(numbers, starts):
        times = [t for part in bag.read(number, list(bag.connections)) for t in part.times]
        assert min(times) == start and max(times) > BEGIN + after
    bag.close()


def test_connection_headers_are_kept(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "x.bag", [("/x", Float64(1), 0), ("/y", String("one"), 1)])
    bag = Ros1Recording(path)
    said: Dict[str, Any] = {one.topic: one.header for one in bag.connections.values()}
    assert sorted(said) == ["/x", "/y"]
    assert said["/x"]["type"] == "std_msgs/Float64"
    assert said["/x"]["message_definition"].strip() == "float64 data"
    ((_, _, data),) = read(bag, {"/x"}, 0)
    assert data == serialized(Float64(1))
    bag.close()


def test_messages_are_in_order_whatever_wrote_the_index(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    write(path, [("a", 1, 0), ("a", 2, 1)])
    content = path.read_bytes()
    # Index of one chunk with one connection: 12 bytes per message, the second message first.
    begin = content.index(struct.pack("<II", *divmod(BEGIN, 10**9)), content.index(b"op=\x04"))
    entries = content[begin : begin + 24]
    swapped = entries[12:] + entries[:12]
    path.write_bytes(content[:begin] + swapped + content[begin + 24 :])
    bag = Ros1Recording(str(path))
    (part,) = bag.read(0, list(bag.connections))
    assert part.times.tolist() == [BEGIN, BEGIN + 1]
    assert [len(message) for message in part.messages] == [5, 6]
    bag.close()


def test_zeros_between_the_index_and_the_next_record_are_skipped(tmp_path: Path) -> None:
    """A public recording has them: its topics were filtered."""
    path = tmp_path / "x.bag"
    write(path, [("a", 1, 0), ("b", 2, 1)])
    content = path.read_bytes()
    place = content.index(b"index_pos=") + len(b"index_pos=")
    (behind,) = struct.unpack_from("<Q", content, place)
    moved = content[:place] + struct.pack("<Q", behind + 800) + content[place + 8 :]
    path.write_bytes(moved[:behind] + bytes(800) + moved[behind:])
    with Ros1Recording(str(path)) as bag:
        assert read(bag, {"/a", "/b"}, 0) == as_read_by_rosbag(path, {"/a", "/b"})


def in_order(chunks: List[List[Slice]]) -> List[Tuple[int, str, bytes]]:
    """Return time, topic and bytes of messages in order of reading; by time in a slice."""
    found = []
    for together in chunks:
        assert len({one.topic for one in together}) == len(together)
        messages = [
            (time, one.topic, data)
            for one in together
            for time, data in zip(one.times.tolist(), one.messages)
        ]
        found += sorted(messages)
    return found


@settings(max_examples=30)
@given(messages, st.integers(0, 10**10), st.none() | st.integers(0, 10**10))
def test_messages_of_a_range_come_in_order_with_exact_times(
    tmp_path_factory: "pytest.TempPathFactory",
    sent: List[Tuple[str, int, int]],
    start: int,
    end: Optional[int],
) -> None:
    sent = [("a", 0, 0), *sent]
    path = write(tmp_path_factory.mktemp("bags") / "x.bag", sent)
    with Ros1Recording(path) as bag:
        assert bag.length == max(time for _, _, time in sent)
        found = in_order(list(slices(bag, ["/a", "/c"], start, end)))
    last = 10**10 if end is None else end
    expected = [
        (time - BEGIN, topic, data)
        for time, topic, data in as_read_by_rosbag(path, {"/a", "/c"})
        if start <= time - BEGIN <= last
    ]
    assert sorted(found) == expected
    assert [time for time, _, _ in found] == [time for time, _, _ in expected]


def test_only_requested_topics_are_read(tmp_path: Path) -> None:
    messages = [("/a", Int32(1), 0), ("/b", Int32(2), 1), ("/a", Int32(3), 2), ("/c", Int32(4), 3)]
    with Ros1Recording(write_bag(tmp_path / "x.bag", messages)) as bag:
        assert bag.count(["/a", "/c"]) == 3
        found = in_order(list(slices(bag, ["/a", "/c"])))
        first = first_messages(bag)
    wanted = [(0, "/a", Int32(1)), (2, "/a", Int32(3)), (3, "/c", Int32(4))]
    assert found == [(time, topic, serialized(message)) for time, topic, message in wanted]
    assert {topic: one.data for topic, one in first.items()} == {
        topic: serialized(Int32(number)) for topic, number in (("/a", 1), ("/b", 2), ("/c", 4))
    }
    assert first["/a"].layout.datatype == "std_msgs/Int32"


def test_first_messages_are_found_wherever_they_are(tmp_path: Path) -> None:
    path = write(tmp_path / "x.bag", [("a", 300, time) for time in range(20)] + [("b", 1, 99)])
    with Ros1Recording(path) as bag:
        assert first_messages(bag)["/b"].data == serialized(String("x"))


def test_earliest_readable_message_is_of_any_publisher(tmp_path: Path) -> None:
    path = write(tmp_path / "x.bag", [("a", 1100, 10), ("/a", 1200, 0)])
    with Ros1Recording(path) as bag:
        assert first_messages(bag)["/a"].data == serialized(String("x" * 1200))


def test_relative_names_become_global(tmp_path: Path) -> None:
    with Ros1Recording(
        write_bag(tmp_path / "x.bag", [("a", Int32(1), 0), ("/a", Int32(2), 5)])
    ) as bag:
        assert list(first_messages(bag)) == ["/a"]
        found = in_order(list(slices(bag, ["/a"])))
    assert found == [(0, "/a", serialized(Int32(1))), (5, "/a", serialized(Int32(2)))]


def test_connection_without_messages_is_not_listed(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    write(path, [("a", 1, 0), ("b", 2, 1)])
    content = path.read_bytes()
    counts, other = struct.pack("<IIII", 0, 1, 1, 1), struct.pack("<IIII", 0, 1, 1, 0)
    assert content.endswith(counts)
    path.write_bytes(content[: -len(other)] + other)
    with Ros1Recording(str(path)) as bag:
        assert list(first_messages(bag)) == ["/a"] and not bag.faults


def error_of(path: Path) -> str:
    with pytest.raises(BagError) as caught, Ros1Recording(str(path)) as bag:
        read(bag, {one.topic for one in bag.connections.values()}, 0)
    text = str(caught.value)
    assert str(path) in text and "\n" not in text
    return text


def test_unreadable_file_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    assert error_of(path).endswith("x.bag: No such file or directory")
    assert error_of(tmp_path).endswith("Is a directory")
    for text in ("", "name,value\n"):
        path.write_text(text)
        assert error_of(path).endswith("x.bag is not a bag")
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:1c\nsize 9\n")
    assert error_of(path).endswith("x.bag only points to a bag; fetch the bag by: git lfs pull")
    path.write_bytes(b"#ROSBAG V1.2\n")
    assert "version 2.0" in error_of(path)
    path.write_bytes(b"#ROSBAG V2.0\n")
    assert "damaged" in error_of(path)
    with rosbag.Bag(str(path), "w"):
        pass
    assert "holds no messages" in error_of(path)


def test_truncated_recording_is_distinguished_from_a_damaged_one(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    bag = rosbag.Bag(str(path), "w")
    bag.write("/x", Float64(1), genpy.Time(1))
    bag.flush()
    whole = path.read_bytes()
    bag.close()
    path.write_bytes(whole)
    said = "has no index because its recording was cut off; make one: rosbag reindex "
    assert error_of(path).endswith(f"{said}{path}")


@pytest.mark.parametrize("part", [0.02, 0.3, 0.5, 0.7, 0.9, 0.999])
def test_truncated_bag_can_be_reindexed(tmp_path: Path, part: float) -> None:
    path = tmp_path / "x.bag"
    write_bag(path, [("/x", String("some words" * 50), time) for time in range(100)])
    content = path.read_bytes()
    path.write_bytes(content[: int(part * len(content))])
    assert "rosbag reindex" in error_of(path)


def test_compressed_bag_with_wrong_bytes(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    write(path, [("a", 300, time) for time in range(1000)], "bz2")
    content = path.read_bytes()
    place = content.index(b"BZh") + 20
    path.write_bytes(content[:place] + b"\xff" * 64 + content[place + 64 :])
    assert "x.bag is damaged (" in error_of(path)


@pytest.mark.parametrize("more", [-1, 1])
def test_chunk_of_another_size_than_stated_is_damaged(tmp_path: Path, more: int) -> None:
    path = tmp_path / "x.bag"
    write(path, [("a", 1, 0)])
    content = path.read_bytes()
    place = content.index(b"size=", content.index(b"compression=none") - 40) + len(b"size=")
    (size,) = struct.unpack_from("<I", content, place)
    path.write_bytes(content[:place] + struct.pack("<I", size + more) + content[place + 4 :])
    assert "a chunk does not have the size that it states" in error_of(path)


@pytest.mark.parametrize("name", [b"", b"rosbag/AesCbcEncryptor"])
def test_only_a_bag_with_a_named_encryptor_is_encrypted(tmp_path: Path, name: bytes) -> None:
    path = tmp_path / "x.bag"
    write(path, [("a", 1, 0)])
    content, begin = path.read_bytes(), len(b"#ROSBAG V2.0\n")
    (length,) = struct.unpack_from("<I", content, begin)
    end = begin + 4 + length
    (padding,) = struct.unpack_from("<I", content, end)
    field = struct.pack("<I", 10 + len(name)) + b"encryptor=" + name
    head = struct.pack("<I", length + len(field)) + content[begin + 4 : end] + field
    rest = struct.pack("<I", padding - len(field)) + content[end + 4 + len(field) :]
    path.write_bytes(content[:begin] + head + rest)
    if name:
        assert error_of(path).endswith("x.bag is encrypted; decrypt it by: rosbag decrypt")
    else:
        with Ros1Recording(str(path)) as bag:
            assert len(read(bag, {"/a"}, 0)) == 1


@settings(max_examples=30)
@given(st.data())
def test_bag_with_damaged_bytes_is_read_or_reported(
    tmp_path_factory: "pytest.TempPathFactory", data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("bags") / "x.bag"
    sent = [("a", number, number * 10**8) for number in range(0, 100, 10)]
    write(path, sent, data.draw(st.sampled_from(["none", "bz2", "lz4"])))
    content = bytearray(path.read_bytes())
    # The header of the file is padded to 4096 bytes, which are ignored.
    places = st.integers(13, 120) | st.integers(4100, len(content) - 1)
    for place in data.draw(st.lists(places, min_size=1, max_size=4)):
        content[place] = data.draw(st.integers(0, 255))
    path.write_bytes(content[: data.draw(st.none() | st.integers(0, len(content)))])
    try:
        with Ros1Recording(str(path)) as bag:
            read(bag, {one.topic for one in bag.connections.values()}, 0)
    except BagError as error:
        assert str(path) in str(error)


def test_bag_is_closed_at_the_end_of_its_block(tmp_path: Path) -> None:
    with Ros1Recording(write(tmp_path / "x.bag", [("a", 1, 0)])) as bag:
        assert len(bag.read(0, list(bag.connections))) == 1
    with pytest.raises(BagError, match="closed file"):
        bag.read(0, list(bag.connections))


@pytest.mark.parametrize("content", [b"no bag", b"#ROSBAG V2.0\n\1\2"])
def test_unreadable_bag_leaves_no_open_file(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.bag"
    path.write_bytes(content)
    with mock.patch.object(Ros1Recording, "close") as close, pytest.raises(BagError):
        Ros1Recording(str(path))
    close.assert_called_once_with()


def test_messages_of_all_chunks_are_counted(tmp_path: Path) -> None:
    sent = [("ab"[number % 3 == 0], 300, number) for number in range(30)]
    with Ros1Recording(write(tmp_path / "x.bag", sent)) as bag:
        assert len(bag.chunks_after(-1)[0]) > 3
        assert [bag.count([topic]) for topic in ("/a", "/b", "/c")] == [20, 10, 0]
