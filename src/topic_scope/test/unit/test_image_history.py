"""History of images: lookup by time, limit in bytes, pins, and clocks that are set."""

from typing import Dict, List, Optional, Tuple

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topic_scope.messages.message_layout import MessageLayout
from topic_scope.sampling.image_history import MOST_BYTES, ImageHistory, histories
from topic_scope.timing.nanoseconds import NS

LAYOUT = MessageLayout("sensor_msgs/Image", (), None, False)
NEVER = (1, 0)


def history(most: int = 1000, seconds: float = 10.0) -> ImageHistory:
    made = ImageHistory(seconds)
    made.most = most
    made.read_as(LAYOUT)
    return made


def add(images: ImageHistory, sent: List[Tuple[int, int, bytes]], newest: int = 0) -> None:
    """Add images: time and time of receipt [ns], and the message."""
    times, received = (numpy.array([one[place] for one in sent], numpy.int64) for place in (0, 1))
    images.add([message for *_, message in sent], times, received, newest)


def message_at(images: ImageHistory, time: int) -> Optional[bytes]:
    found = images.at(time)
    assert found is not None
    return found.message


@given(st.lists(st.integers(0, 50), min_size=1, max_size=20), st.integers(-1, 51))
def test_image_of_a_time_is_the_latest_at_or_before_it(times: List[int], asked: int) -> None:
    images = history()
    for place, time in enumerate(times):
        add(images, [(time, 100 + place, bytes([place]))])
    before = [(time, place) for place, time in enumerate(times) if time <= asked]
    found = images.at(asked)
    assert (None if found is None else found.message) == (
        bytes([max(before)[1]]) if before else None
    )
    newest = images.newest
    assert newest is not None and newest.message == bytes([len(times) - 1])
    assert images.first == min(times)


@given(
    st.dictionaries(st.integers(0, 50), st.integers(0, 9), min_size=1),
    st.tuples(st.integers(0, 50), st.integers(0, 50)),
    st.integers(0, 40),
)
def test_messages_beyond_the_limit_are_dropped_pinned_ones_last(
    sizes: Dict[int, int], pinned: Tuple[int, int], most: int
) -> None:
    images, kept = history(most), set()
    images.pin(*pinned)
    for place, (time, size) in enumerate(sizes.items()):
        add(images, [(time, place, b"x" * size)])
        before = {*kept, time}
        kept = {one for one in before if message_at(images, one) is not None}
        assert time in kept and (sum(sizes[one] for one in kept) <= most or kept == {time})
        is_pinned = {one: pinned[0] <= one <= pinned[1] for one in before}
        if any(is_pinned[one] for one in before - kept):
            assert all(is_pinned[one] for one in kept - {time})


def test_dropped_image_keeps_its_time() -> None:
    images = history(10)
    add(images, [(NS, 1, b"first"), (2 * NS, 2, b"second")])
    assert message_at(images, NS) is None
    assert message_at(images, 2 * NS) == b"second"
    assert (images.first, images.first_kept) == (NS, 2 * NS)
    found = images.at(NS)
    assert found is not None and (found.received, found.layout) == (1, LAYOUT)


def test_image_larger_than_the_limit_is_kept_until_the_next() -> None:
    images = history(3)
    add(images, [(1, 1, b"large")])
    assert message_at(images, 1) == b"large"
    add(images, [(2, 2, b"next!")])
    assert message_at(images, 1) is None and message_at(images, 2) == b"next!"


def test_images_older_than_the_history_are_forgotten_unless_pinned() -> None:
    images = history(seconds=10.0)
    sent = [(second * NS, second, b"x") for second in range(1, 5)]
    images.pin(2 * NS, 3 * NS)
    add(images, sent, 4 * NS)
    add(images, [(14 * NS, 14, b"y")], 14 * NS)
    assert images.first == 2 * NS
    found = images.at(5 * NS)
    assert found is not None and found.time == 4 * NS
    images.pin(*NEVER)
    add(images, [(15 * NS, 15, b"z")], 15 * NS)
    assert images.first == 14 * NS


def test_forgotten_images_take_no_memory() -> None:
    images = history(seconds=1.0)
    for second in range(0, 20, 2):
        sent = [(second * NS, 2 * second, b"a"), (second * NS + 1, 2 * second + 1, b"b")]
        add(images, sent, second * NS)
        assert images.first_kept == second * NS


def test_newest_image_is_kept_if_its_stamp_is_old() -> None:
    images = history(seconds=1.0)
    add(images, [(5 * NS, 1, b"a")], 5 * NS)
    add(images, [(2 * NS, 2, b"late")], 5 * NS)
    newest = images.newest
    assert newest is not None and newest.message == b"late"


def test_all_times_move_with_their_clock() -> None:
    images = history(seconds=10.0, most=1)
    images.pin(1 * NS, 2 * NS)
    add(images, [(1 * NS, 1, b"a")], NS)
    images.move(-NS)
    assert images.first == images.first_kept == 0 and message_at(images, 0) == b"a"
    add(images, [(20 * NS, 2, b"b")], 20 * NS)
    assert images.first == 0  # the pinned span has moved as well
    assert images.at(-1) is None


def test_messages_before_a_layout_are_ignored() -> None:
    images = ImageHistory(1.0)
    add(images, [(1, 1, b"a")])
    assert images.newest is None and images.at(1) is None and images.first_kept is None


@pytest.mark.parametrize("count", [1, 3])
def test_topics_share_the_limit(count: int) -> None:
    names = [f"/{place}" for place in range(count)]
    made = histories(names, {}, 5.0)
    assert [made[name].most for name in names] == [MOST_BYTES // count] * count
    fewer = histories(names[:1], made, 5.0)
    assert fewer == {names[0]: made[names[0]]} and fewer[names[0]].most == MOST_BYTES


def test_lower_limit_drops_messages_immediately() -> None:
    (name, images), *_ = histories(["/a"], {}, 5.0).items()
    images.read_as(LAYOUT)
    half = bytes(MOST_BYTES // 2)
    add(images, [(1, 1, half), (2, 2, half)])
    assert images.first_kept == 1
    histories([name, "/b"], {name: images}, 5.0)
    assert images.first_kept == 2
