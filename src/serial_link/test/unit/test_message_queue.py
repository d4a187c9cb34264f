"""Queue: reliable messages are never lost, and the newest values of streams are kept."""

import threading
from typing import Any, List

from hypothesis import given
from hypothesis import strategies as st

from nodekit.testing.waiting import in_thread, wait_until
from serial_link.host.message_queue import DEPTH, MOST_KEPT, MessageQueue


def fetch_all(queue: MessageQueue) -> List[Any]:
    found = []
    while True:
        message = queue.get(0.0)
        if message is None:
            return found
        found.append(message)


@given(st.lists(st.one_of(st.none(), st.integers(0, 3), st.just("fetch")), max_size=120))
def test_every_schedule(steps: List[Any]) -> None:
    queue, kept, sent, found = MessageQueue(), [], {}, []
    for number, step in enumerate(steps):
        if step is None:
            queue.put_reliable(("kept", number))
            kept.append(("kept", number))
        elif step == "fetch":
            message = queue.get(0.0)
            found += [message] if message is not None else []
        else:
            queue.put(step, (step, number))
            sent.setdefault(step, []).append((step, number))
    found += fetch_all(queue)
    assert [one for one in found if one[0] == "kept"] == kept
    came = 0
    for stream, values in sent.items():
        heard = [one for one in found if one[0] == stream]
        came += len(heard)
        assert heard == sorted(heard) and heard[-1] == values[-1]  # in order, and the newest
    assert came + queue.dropped == sum(map(len, sent.values()))


def test_burst_is_kept_up_to_depth_then_only_newest() -> None:
    queue = MessageQueue()
    for value in range(DEPTH):
        queue.put("a", value)
    assert fetch_all(queue) == list(range(DEPTH)) and queue.dropped == 0
    for value in range(DEPTH + 1):
        queue.put("a", value)
    assert fetch_all(queue) == [DEPTH] and queue.dropped == DEPTH


def test_stream_may_have_its_own_depth() -> None:
    queue = MessageQueue(depth=2)
    for value in range(3):
        queue.put("deep", value, depth=3)
        queue.put("other", value)
    assert fetch_all(queue) == [0, 2, 1, 2] and queue.dropped == 2


def test_streams_alternate_after_reliable_messages() -> None:
    queue = MessageQueue()
    for value in range(3):
        queue.put("a", f"a{value}")
    queue.put("b", "b0")
    queue.put_reliable("kept")
    assert fetch_all(queue) == ["kept", "a0", "b0", "a1", "a2"]


def test_far_too_many_are_refused_and_counted() -> None:
    queue = MessageQueue()
    assert all(queue.put_reliable(number) for number in range(MOST_KEPT))
    assert not queue.put_reliable("one more")
    assert queue.refused == 1 and len(fetch_all(queue)) == MOST_KEPT


def test_cleared_messages_are_not_returned_or_counted() -> None:
    queue = MessageQueue()
    queue.put_reliable(1)
    queue.put("a", 2)
    queue.clear()
    assert fetch_all(queue) == [] and queue.dropped == 0


def test_waiting_reader_gets_message_or_none_on_close() -> None:
    queue, found = MessageQueue(), []
    waiting = in_thread(lambda: found.append(queue.get(90.0)))
    queue.put("a", "came")
    waiting.join(30.0)
    assert found == ["came"]
    waiting = in_thread(lambda: found.append(queue.get(90.0)))
    wait_until(lambda: queue.is_idle, lambda: "the reader does not wait")
    queue.close()
    waiting.join(30.0)
    assert found == ["came", None]


def test_queue_is_idle_only_while_its_reader_waits() -> None:
    queue, found = MessageQueue(), []
    assert not queue.is_idle
    waiting = threading.Thread(target=lambda: found.append(queue.get(30.0)))
    waiting.start()
    wait_until(lambda: queue.is_idle, lambda: "the reader does not wait")
    queue.put("a", 1)
    assert not queue.is_idle  # the reader may be handling the message
    waiting.join(30.0)
    assert found == [1] and not queue.is_idle
    assert queue.get(0.0) is None and not queue.is_idle


def test_message_can_be_replaced_after_wait() -> None:
    queue = MessageQueue(depth=1)
    assert not queue.wait(0.0)
    queue.put("a", 1)
    assert queue.wait(30.0)
    queue.put("a", 2)
    assert fetch_all(queue) == [2]
    queue.close()
    assert queue.wait(30.0)
