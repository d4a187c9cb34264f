"""What is read from a bag, and what is said of one that cannot be read."""

from pathlib import Path
from typing import List

import genpy
import pytest
import rosbag
from bags import BEGIN, write_bag
from hypothesis import given
from hypothesis import strategies as st
from std_msgs.msg import Float64, Int32, String

from topic_scope.bag.bag_reading import BagError, BagReader

times = st.lists(st.integers(0, 10**10), min_size=1, max_size=20).map(lambda list: [0] + list)


@given(times, st.integers(0, 10**10), st.none() | st.integers(0, 10**10))
def test_messages_of_a_range_come_in_order_with_exact_times(
    tmp_path_factory: "pytest.TempPathFactory", times: List[int], start: int, end: int
) -> None:
    path = tmp_path_factory.mktemp("bags") / "x.bag"
    write_bag(path, [("/x", Float64(time), time) for time in times])
    with BagReader(str(path)) as bag:
        samples = list(bag.samples(["/x"], start, end))
    last = 10**10 if end is None else end
    assert [sample.time for sample in samples] == sorted(t for t in times if start <= t <= last)
    assert all(sample.message.data == sample.time for sample in samples)


def test_only_the_topics_asked_for_come(tmp_path: Path) -> None:
    messages = [("/a", Int32(1), 0), ("/b", Int32(2), 1), ("/a", Int32(3), 2), ("/c", Int32(4), 3)]
    with BagReader(write_bag(tmp_path / "x.bag", messages)) as bag:
        assert bag.topics == ["/a", "/b", "/c"]
        found = [(sample.topic, sample.message.data) for sample in bag.samples(["/a", "/c"])]
        assert bag.count(["/a", "/c"]) == 3
        assert bag.first_message("/a").data == 1
    assert found == [("/a", 1), ("/a", 3), ("/c", 4)]


def test_relative_names_are_taken_for_global_ones(tmp_path: Path) -> None:
    with BagReader(write_bag(tmp_path / "x.bag", [("a", Int32(1), 0), ("/a", Int32(2), 5)])) as bag:
        assert bag.topics == ["/a"]
        assert [(s.topic, s.message.data) for s in bag.samples(["/a"])] == [("/a", 1), ("/a", 2)]


def test_length_is_from_the_first_message_to_the_last_of_any_topic(tmp_path: Path) -> None:
    messages = [("/a", Int32(1), 0), ("/b", Int32(2), 2 * 10**9)]
    with BagReader(write_bag(tmp_path / "x.bag", messages)) as bag:
        assert bag.length == pytest.approx(2e9, abs=1e3)


def refusal(path: Path) -> str:
    """Return what is said of a bag when it is read to its end."""
    with pytest.raises(BagError) as caught:
        with BagReader(str(path)) as bag:
            list(bag.samples(bag.topics))
    text = str(caught.value)
    assert str(path) in text
    return text


def test_file_that_is_not_there(tmp_path: Path) -> None:
    assert refusal(tmp_path / "no.bag").endswith("no.bag: No such file or directory")
    assert refusal(tmp_path).endswith("Is a directory")


@pytest.mark.parametrize("content", [b"", b"time,y\n0,1\n"])
def test_file_that_is_no_bag(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "x.bag").write_bytes(content)
    assert refusal(tmp_path / "x.bag").endswith("x.bag is no bag")


def test_bag_without_messages(tmp_path: Path) -> None:
    write_bag(tmp_path / "x.bag", [])
    assert refusal(tmp_path / "x.bag").endswith("x.bag holds no messages")


def test_bag_whose_recording_was_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    bag = rosbag.Bag(str(path), "w")
    bag.write("/x", Int32(1))
    bag.flush()
    (tmp_path / "cut.bag").write_bytes(path.read_bytes())
    bag.close()
    text = refusal(tmp_path / "cut.bag")
    assert text.endswith(
        "has no index, as its recording was cut off; make one: rosbag reindex "
        f"{tmp_path / 'cut.bag'}"
    )


@pytest.mark.parametrize("part", [0.02, 0.3, 0.5, 0.7, 0.9, 0.999])
def test_bag_that_ends_early_or_has_wrong_bytes(tmp_path: Path, part: float) -> None:
    path = tmp_path / "x.bag"
    write_bag(path, [("/x", String("some words" * 50), time) for time in range(100)])
    content = path.read_bytes()
    place = int(part * len(content))
    (tmp_path / "early.bag").write_bytes(content[:place])
    assert "rosbag reindex" in refusal(tmp_path / "early.bag")
    (tmp_path / "wrong.bag").write_bytes(content[:place] + b"\xff" * 64 + content[place + 64 :])
    try:
        with BagReader(str(tmp_path / "wrong.bag")) as bag:
            list(bag.samples(bag.topics))
    except BagError as error:  # of any other error the test dies
        assert "wrong.bag" in str(error)


def test_compressed_bag_with_wrong_bytes(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    with rosbag.Bag(str(path), "w", compression=rosbag.Compression.BZ2) as bag:
        for number in range(1000):
            bag.write("/x", Int32(number), genpy.Time(1, number))
    content = path.read_bytes()
    place = content.index(b"BZh") + 200
    path.write_bytes(content[:place] + b"\xff" * 64 + content[place + 64 :])
    assert "x.bag is broken (" in refusal(path)


def test_message_that_is_too_short_for_its_type(tmp_path: Path) -> None:
    path = tmp_path / "x.bag"
    with rosbag.Bag(str(path), "w") as bag:
        bag.write("/x", Int32(1), genpy.Time(1, 0))
        raw = (Int32._type, b"\0\0", Int32._md5sum, Int32)
        bag.write("/x", raw, genpy.Time(1, 1), raw=True)
    assert "x.bag is broken (" in refusal(path)


def test_topic_that_changes_its_type(tmp_path: Path) -> None:
    # rosbag writes one type for each name, but recorded by somebody else these are one topic.
    write_bag(tmp_path / "x.bag", [("/x", Int32(1), 0), ("x", Float64(1.0), 1)])
    assert refusal(tmp_path / "x.bag").endswith("the messages of /x change their type")


def test_begin_is_no_rounded_number() -> None:
    assert int(float(BEGIN)) != BEGIN
