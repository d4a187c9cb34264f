"""Tests of shared memory over real sockets, without ROS."""

import contextlib
import gc
import mmap
import os
import socket
import struct
import threading
import types

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit.shared_memory import channel, frame, memory, shared_connection
from nodekit.shared_memory.channel import Loan, ReaderChannel, WriterChannel
from nodekit.shared_memory.frame import Frame
from nodekit.shared_memory.memory import ReadMemory, WrittenMemory
from nodekit.shared_memory.segment_pool import IDLE_S, Segment
from nodekit.shared_memory.shared_connection import MOST_IN_FLIGHT, SharedConnection, TopicMemory
from nodekit.testing.waiting import wait_until

CONTENT = bytes(range(256)) * 4000


def segments(topic):
    """Return the number of a topic's segments."""
    return len(topic.pool.numbers())


def is_lent(topic):
    """Return whether a subscriber has a segment of a topic, or waits for one."""
    return any(one.users for one in topic.pool._segments.values())


def descriptors():
    gc.collect()
    return len(os.listdir("/proc/self/fd"))


@pytest.fixture(autouse=True)
def keeper(monkeypatch):
    """Have the thread that gives memory back look often, and end with each test."""
    monkeypatch.setattr(shared_connection, "IDLE_S", 0.01)
    yield
    wait_until(
        lambda: not any(one.name == "shared memory" for one in threading.enumerate()),
        lambda: "memory is left",
    )


class Subscriber:
    """A connection of a publisher, and the other end of it."""

    def __init__(self, stack, depth=10, topic=None):
        ours, self.socket = (stack.enter_context(end) for end in socket.socketpair())
        self.socket.setblocking(False)
        self.topic = topic or TopicMemory(threading.RLock())
        self.lock = self.topic._lock
        self.channel = ReaderChannel()
        name = self.channel.name
        self.link = SharedConnection("receiver", ours, self.lock, depth, self.topic, name)
        stack.callback(self.close)

    def close(self):
        """Close the topic."""
        with self.lock:
            self.topic.close()

    def collect(self):
        """Reclaim what subscribers have read."""
        with self.lock:
            self.topic.collect()

    def trim(self):
        """Give up unused memory; return the number of segments that are left."""
        with self.lock:
            self.topic.pool.trim(1e12)
        return segments(self.topic)

    def send(self, content):
        """Send a message; return whether that was possible."""
        with self.lock:
            assert self.link.shares()
            segment = self.topic.write([content], 0, len(content), 0)
            if segment is None:
                return False
            if not self.link.share(segment):
                self.link.stall()
            return True

    def announced(self):
        """Return the received announcements."""
        data = b""
        with contextlib.suppress(BlockingIOError):
            data = self.socket.recv(1_000_000)
        assert len(data) % frame.SIZE == 0
        return [frame.unpack_from(data, start) for start in range(0, len(data), frame.SIZE)]

    def borrow(self, one):
        """Begin to read a message; give its memory and the loan."""
        return self.channel.receive(one.segment), Loan(self.channel, one.segment)

    def read(self):
        """Read all messages that were announced."""
        found = []
        for one in self.announced():
            part, loan = self.borrow(one)
            found.append(part.read(one.start, one.stop))
            del loan
        return found

    def flush(self):
        """Run the background service once."""
        with self.lock:
            self.link.flush(0.0)


@pytest.fixture
def subscribe():
    """Give a maker of subscribers."""
    with contextlib.ExitStack() as stack:
        yield lambda *args, **kwds: Subscriber(stack, *args, **kwds)


def test_memory_reader_sees_the_written_bytes():
    written = WrittenMemory(len(CONTENT))
    read = ReadMemory(written.descriptor)
    written.write([CONTENT[:10], bytearray(CONTENT[10:])])
    assert read.read(0, len(CONTENT)) == CONTENT
    written.close()
    assert read.read(5, 300) == CONTENT[5:300]


def test_memory_cannot_be_written_by_a_reader():
    written = WrittenMemory(4096)
    try:
        with pytest.raises(PermissionError):
            mmap.mmap(written.descriptor, 4096)
        with pytest.raises(PermissionError):
            os.ftruncate(written.descriptor, 0)
        with pytest.raises(PermissionError):
            os.write(written.descriptor, b"x")
        view = ReadMemory(written.descriptor).view(0, 4096, None)
        with pytest.raises(TypeError):
            view[0] = 1
    finally:
        written.close()


def test_view_keeps_its_memory_until_the_last_slice_is_gone():
    kept = types.SimpleNamespace()
    gone = []

    class Kept:
        def __del__(self):
            gone.append(True)

    written = WrittenMemory(len(CONTENT))
    written.write([CONTENT])
    view = ReadMemory(written.descriptor).view(0, len(CONTENT), Kept())
    written.close()
    kept.part = view[256:512]
    del view
    gc.collect()
    assert bytes(kept.part) == CONTENT[256:512]
    assert not gone
    del kept.part
    gc.collect()
    assert gone


def test_memory_without_descriptors_is_an_error_and_leaks_none(monkeypatch):
    before = descriptors()

    def refuse(*_args):
        raise OSError("no memory")

    monkeypatch.setattr(memory.os, "posix_fallocate", refuse)
    with pytest.raises(OSError, match="no memory"):
        WrittenMemory(4096)
    assert descriptors() == before


@given(st.tuples(*[st.integers(0, 2**31)] * 3), st.integers(0, 9), st.integers(0, 2**40))
def test_frame_is_read_as_it_was_written(places, field, lost):
    start, stop, size = sorted(places)
    one = Frame(7, size, start, stop, field, lost)
    assert frame.unpack_from(b"before" + one.pack(), 6) == one


def test_frame_with_an_array_out_of_bounds_is_refused():
    with pytest.raises(ValueError, match="malformed"):
        frame.unpack_from(Frame(1, 10, 5, 11, 0, 0).pack(), 0)


def test_messages_reuse_one_segment(subscribe):
    one = subscribe()
    for number in range(5):
        assert one.send(bytes([number]) * 300_000)
        assert one.read() == [bytes([number]) * 300_000]
    assert segments(one.topic) == 1


def test_forked_child_does_not_release_its_parents_loan(subscribe):
    one = subscribe()
    one.send(b"a" * 300_000)
    (announced,) = one.announced()
    part, loan = one.borrow(announced)
    child = os.fork()
    if child == 0:
        del loan
        os._exit(0)
    os.waitpid(child, 0)
    one.collect()
    assert is_lent(one.topic)
    del part, loan
    one.collect()
    assert not is_lent(one.topic)


def test_growing_messages_arrive_whole(subscribe):
    one = subscribe()
    for size in (0, 1, 70_000, 3_000_000, 10, 64_000_000, 300_000):
        content = os.urandom(100).ljust(size, b"x")[:size]
        assert one.send(content)
        assert one.read() == [content]
    assert segments(one.topic) == 1


def test_message_in_use_is_not_overwritten(subscribe):
    one = subscribe()
    one.send(b"a" * 300_000)
    (announced,) = one.announced()
    part, loan = one.borrow(announced)
    view = part.view(0, 300_000, loan)
    del loan
    for _ in range(2 * MOST_IN_FLIGHT):
        one.send(b"b" * 300_000)
        one.read()
    assert bytes(view) == b"a" * 300_000
    assert segments(one.topic) == 2
    del view, part
    one.send(b"c" * 300_000)
    one.send(b"d" * 300_000)
    assert one.read() == [b"c" * 300_000, b"d" * 300_000]
    assert segments(one.topic) == 2


def test_stalled_reader_gets_the_newest_and_the_number_missed(subscribe):
    one = subscribe(depth=2)
    for number in range(10):
        one.send(bytes([number]) * 300_000)
    assert segments(one.topic) == 5  # two announced, two that wait, the next
    assert one.link.lost == 6
    assert one.read() == [bytes([number]) * 300_000 for number in (0, 1)]
    one.flush()
    (first, second) = one.announced()
    assert (first.lost, second.lost) == (6, 6)
    assert one.borrow(first)[0].read(0, 1) == bytes([8])
    assert one.link.sent == 4


def test_background_service_waits_for_the_reader_not_for_the_socket(subscribe):
    one = subscribe(depth=1)
    one.send(b"a" * 300_000)
    assert one.link.awaited()[0] == one.link.fileno()
    one.send(b"b" * 300_000)
    one.send(b"c" * 300_000)
    descriptor, _ = one.link.awaited()
    assert descriptor == one.link._channel.fileno()
    assert one.read() == [b"a" * 300_000, b"b" * 300_000]
    one.flush()
    assert one.read() == [b"c" * 300_000]


def test_slow_reader_does_not_hold_memory_of_a_fast_one(subscribe):
    slow = subscribe(depth=1)
    fast = subscribe(topic=slow.topic)
    for number in range(20):
        with slow.lock:
            assert slow.link.shares() and fast.link.shares()
            segment = slow.topic.write([bytes([number]) * 300_000], 0, 300_000, 0)
            slow.link.share(segment)
            assert fast.link.share(segment)
        assert fast.read() == [bytes([number]) * 300_000]
    assert fast.link.lost == 0
    assert slow.link.lost == 17
    assert segments(slow.topic) <= 4


def test_reader_that_is_gone_returns_all_it_had(subscribe):
    one = subscribe()
    one.send(b"a" * 300_000)
    one.send(b"b" * 300_000)
    for announced in one.announced():
        assert one.borrow(announced)
    loans = segments(one.topic)
    one.channel = None
    one.socket.close()
    gc.collect()
    one.collect()
    assert loans == segments(one.topic) == 2
    assert one.trim() == 0
    one.send(b"c" * 300_000)
    assert one.link.fileno() < 0


def test_connection_that_ends_releases_waiting_messages(subscribe):
    one = subscribe(depth=3)
    for number in range(6):
        one.send(bytes([number]) * 300_000)
    one.link.drop()
    assert one.trim() == 3  # those that were announced


def test_memory_that_is_full_sends_no_message_by_it(subscribe, monkeypatch):
    one = subscribe()
    monkeypatch.setattr(one.topic.pool, "_limit", 1_000_000)
    assert one.send(b"a" * 600_000)
    assert not one.send(b"b" * 600_000)
    assert one.read() == [b"a" * 600_000]
    assert one.send(b"c" * 600_000)


def test_unused_memory_is_given_back_at_both_ends(subscribe, monkeypatch):
    before = descriptors()
    one = subscribe()
    one.send(b"a" * 300_000)
    one.read()
    assert len(one.channel._memories) == 1
    later = shared_connection.time.monotonic() + IDLE_S
    pause = shared_connection.time.sleep
    clock = types.SimpleNamespace(monotonic=lambda: later, sleep=pause)
    monkeypatch.setattr(shared_connection, "time", clock)
    wait_until(lambda: segments(one.topic) == 0, lambda: "the segment is still there")
    one.channel.forget()
    assert not one.channel._memories
    one.send(b"b" * 300_000)
    assert one.read() == [b"b" * 300_000]
    one.close()
    one.channel = None
    assert descriptors() <= before + 2  # the two ends of the connection


def test_closed_topic_leaves_no_thread(subscribe, monkeypatch):
    monkeypatch.setattr(shared_connection, "IDLE_S", 600.0)
    one = subscribe()
    one.send(b"a message")
    trimmer = one.topic._trimmer
    assert trimmer.is_alive()
    one.close()
    trimmer.join(20.0)
    assert not trimmer.is_alive()


def test_message_to_a_subscriber_that_has_gone_is_not_lent(subscribe):
    one = subscribe()
    one.send(b"a" * 300_000)
    one.read()
    one.channel = None  # its end of the connection is still open
    gc.collect()
    one.send(b"b" * 300_000)
    assert one.link.fileno() < 0
    assert one.trim() == 0


def test_fifty_changing_subscribers_get_every_message_while_connected(subscribe):
    first = subscribe()
    there = [first, *(subscribe(topic=first.topic) for _ in range(49))]
    number = 0
    while there:
        content = bytes([number]) * 300_000
        with first.lock:
            assert all(one.link.shares() for one in there)
            segment = first.topic.write([content], 0, len(content), 0)
            assert all([one.link.share(segment) for one in there])
        assert all(one.read() == [content] for one in there)
        for one in there[::3]:
            one.channel = None
            one.socket.close()
        there = [one for number, one in enumerate(there) if number % 3]
        number += 1
    first.collect()
    assert first.trim() == 0


def test_channel_that_cannot_be_reached_is_an_error_and_leaks_nothing():
    before = descriptors()
    for name in ("missing", "x" * 200):
        with pytest.raises(OSError):
            WriterChannel(name)
    assert descriptors() == before


def test_subscriber_of_another_user_is_refused(monkeypatch):
    reader = ReaderChannel()
    monkeypatch.setattr(channel.os, "geteuid", lambda: os.getuid() + 1)
    with pytest.raises(OSError, match="another user"):
        WriterChannel(reader.name)


def test_publisher_of_another_user_gets_no_channel(monkeypatch):
    reader = ReaderChannel()
    other, own = WriterChannel(reader.name), WriterChannel(reader.name)
    segment = Segment(1, WrittenMemory(4096))
    own.announce(segment, [1])
    answers = [False, True]
    monkeypatch.setattr(channel, "_is_of_this_user", lambda sock: answers.pop(0))
    assert reader.receive(1).size == 4096
    assert not other.collect()
    assert own.collect()
    own.close()
    segment.memory.close()


def test_refusal_is_reported_once_and_messages_go_by_the_connection():
    ours, theirs = socket.socketpair()
    with ours, theirs:
        lock = threading.RLock()
        link = SharedConnection("receiver", ours, lock, None, TopicMemory(lock), "missing")
        refused = []
        link.on_rejected = refused.append
        assert not link.shares()
        assert not link.shares()
        assert len(refused) == 1 and "refused" in refused[0]


def test_channel_of_an_ended_connection_is_closed():
    reader = ReaderChannel()
    writer = WriterChannel(reader.name)
    assert writer.collect()
    del reader
    assert not writer.collect()
    assert writer.fileno() < 0


def test_segment_that_was_not_sent_is_an_error():
    reader = ReaderChannel()
    with pytest.raises(OSError):
        reader.receive(3)
    writer = WriterChannel(reader.name)
    with pytest.raises(OSError):
        reader.receive(3)
    segment = Segment(1, WrittenMemory(4096))
    writer.announce(segment, [1])
    with pytest.raises(OSError, match="segment 3 was announced, and 1 sent"):
        reader.receive(3)
    writer.announce(segment, [1])
    writer._socket.send(struct.pack("<II", 2, 2))
    assert reader.receive(1).size == 4096
    with pytest.raises(OSError, match="segment 2 was sent without memory"):
        reader.receive(2)
    writer.close()
    segment.memory.close()


def test_reader_drops_memory_that_the_publisher_has_given_up(subscribe):
    one = subscribe()
    for size in (300_000, 30_000_000):
        assert one.send(b"x" * size)
        assert one.read() == [b"x" * size]
    assert len(one.channel._memories) == 1


def test_messages_announced_before_the_publisher_closes_arrive(subscribe):
    subscriber = subscribe()
    for number in range(3):
        assert subscriber.send(bytes([number]) * 300_000)
    announced = subscriber.announced()
    part, loan = subscriber.borrow(announced[0])
    assert part.read(0, 300_000) == bytes(300_000)
    del loan  # given back, but the publisher no longer reads that
    subscriber.close()
    for one in announced[1:]:
        part, loan = subscriber.borrow(one)
        assert part.read(0, 300_000) == bytes([one.segment - 1]) * 300_000
        del loan


def test_channel_of_a_connection_that_ends_before_it_reads_is_closed(subscribe):
    subscriber = subscribe()
    assert subscriber.send(b"x" * 300_000)
    subscriber.channel = None
    subscriber.collect()
    assert not is_lent(subscriber.topic)


def test_connection_with_a_withdrawn_channel_does_not_wait(subscribe):
    subscriber = subscribe(depth=10)
    for _ in range(MOST_IN_FLIGHT + 1):
        assert subscriber.send(b"x" * 300_000)
    assert subscriber.link.held
    subscriber.announced()
    subscriber.channel = None
    subscriber.collect()
    assert subscriber.link.awaited()[0] >= 0
    subscriber.flush()
    assert not subscriber.link.held
