"""Queue bounded in bytes: the newest messages are kept, in order."""

from typing import List

from hypothesis import given
from hypothesis import strategies as st

from ros2_bridge.ros2.message_queue import MessageQueue
from ros2_bridge.ros2.received_message import ReceivedMessage

MOST = 100


def message(number: int, size: int) -> ReceivedMessage:
    return ReceivedMessage(bytes(size), b"sender", number)


def numbers(batch: List[ReceivedMessage]) -> List[int]:
    return [one.number or 0 for one in batch]


@given(st.lists(st.integers(0, 150)))
def test_newest_messages_within_the_bound_are_kept(sizes: List[int]) -> None:
    queue = MessageQueue(MOST)
    for number, size in enumerate(sizes, 1):
        queue.add(message(number, size))
    kept = numbers(queue.pop_batch(10**6))
    assert kept == list(range(len(sizes) - len(kept) + 1, len(sizes) + 1))
    assert kept or not sizes  # the newest is kept, even if it is too large
    first = len(sizes) - len(kept)  # index of the oldest kept message
    assert sum(sizes[first:]) <= MOST or len(kept) == 1
    if first > 0 and sizes[first - 1]:
        assert sum(sizes[first - 1 :]) > MOST
    assert not queue and queue.pop_batch(10**6) == []


@given(st.lists(st.integers(0, 50), max_size=20), st.integers(1, 60))
def test_batches_are_in_order_and_within_their_size(sizes: List[int], most: int) -> None:
    queue, found = MessageQueue(10**6), []
    for number, size in enumerate(sizes, 1):
        queue.add(message(number, size))
    while queue:
        before, batch = len(queue), queue.pop_batch(most)
        assert len(queue) == before - len(batch)
        assert sum(len(one.data) for one in batch) <= most or len(batch) == 1
        found += numbers(batch)
    assert found == list(range(1, len(sizes) + 1))


def test_space_of_removed_messages_is_free_again() -> None:
    queue = MessageQueue(MOST)
    for number in range(1, 10):
        queue.add(message(number, MOST))
        assert numbers(queue.pop_batch(1)) == [number]
    queue.add(message(10, 60))
    queue.add(message(11, 40))
    assert numbers(queue.pop_batch(MOST)) == [10, 11]
