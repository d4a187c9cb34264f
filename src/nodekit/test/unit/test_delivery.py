"""Delivery over real sockets, without ROS: what a receiver that does not read costs the others."""

import contextlib
import select
import socket
import struct
import threading
import time
import types

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit.transport import delivery

TIME_OUT = 20.0  # s
BIG = b"b" * 1_000_000  # more than a pair's buffers take


class RecordingLink(delivery.Link):
    """A link that keeps its reports."""

    def __init__(self, sock, lock=None):
        super().__init__("receiver", sock, lock or threading.RLock())
        self.reports = []

    def report(self, stalled, lost):
        self.reports.append((stalled, lost))


class Clock:
    """Stands in for the modules time and select: only polling, in vain, takes time."""

    POLLOUT = select.POLLOUT

    def __init__(self):
        self.now = 1000.0

    def monotonic(self):
        return self.now

    def poll(self):
        return types.SimpleNamespace(register=lambda descriptor, events: None, poll=self.wait)

    def wait(self, milliseconds):
        self.now += milliseconds / 1000
        return []


@pytest.fixture
def pairs():
    """Give a maker of connected sockets with small buffers: (ours, the receiver's)."""
    with contextlib.ExitStack() as stack:

        def make():
            ours, theirs = socket.socketpair()
            ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
            stack.enter_context(ours)
            stack.enter_context(theirs)
            return ours, theirs

        yield make


@pytest.fixture
def unwatched(monkeypatch):
    """Keep the background thread out; gives the links that it would have got."""
    links = []
    monkeypatch.setattr(delivery, "_drain", types.SimpleNamespace(watch=links.append))
    return links


@pytest.fixture
def clock(monkeypatch, unwatched):
    """Replace the clock and polling."""
    clock = Clock()
    monkeypatch.setattr(delivery, "time", clock)
    monkeypatch.setattr(delivery, "select", clock)
    return clock


def packet(number, size):
    return struct.pack("<II", size, number) + bytes([number % 251]) * size


def unpack(stream):
    """Take a received stream apart; an assertion fails where a message is torn."""
    numbers = []
    while stream:
        size, number = struct.unpack_from("<II", stream)
        message = packet(number, size)
        assert stream.startswith(message)
        numbers.append(number)
        stream = stream.partition(message)[2]
    return numbers


def read_all(sock):
    sock.setblocking(False)
    data = b""
    with contextlib.suppress(BlockingIOError):
        while True:
            data += sock.recv(1 << 20)
    return data


def receive(sock, size):
    sock.settimeout(TIME_OUT)
    data = b""
    while len(data) < size:
        data += sock.recv(size - len(data))
    return data


def wait_until(condition):
    deadline = time.monotonic() + TIME_OUT
    while not condition():
        assert time.monotonic() < deadline, "timed out"
        time.sleep(0.005)


@given(
    st.lists(
        st.one_of(
            st.tuples(st.just("offer"), st.integers(0, 30_000)),
            st.tuples(st.just("read"), st.integers(1, 20_000)),
            st.tuples(st.just("flush"), st.just(0)),
        ),
        max_size=60,
    )
)
def test_messages_are_whole_in_order_and_accounted_for(steps):
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        theirs.setblocking(False)
        link = RecordingLink(ours)
        received, offered = b"", 0
        for step, size in steps:
            if step == "offer":
                if link.stalled:
                    link.hold(packet(offered, size), 1)
                else:
                    link.stalled = not link.send(packet(offered, size), 1)
                offered += 1
            elif step == "flush":
                link.flush()
            else:
                with contextlib.suppress(BlockingIOError):
                    received += theirs.recv(size)
        while not link.flush():
            received += read_all(theirs)
        received += read_all(theirs)
    assert link.sent_bytes == len(received)
    numbers = unpack(received)
    assert numbers == sorted(set(numbers))
    assert numbers[-1:] == list(range(offered))[-1:], "the last message always arrives"
    assert len(numbers) == link.sent == offered - link.lost
    assert not link.stalled


def test_full_receivers_together_are_waited_for_once(pairs, clock):
    links = [delivery.Link("full", pairs()[0], threading.RLock()) for _ in range(20)]
    start = clock.now
    delivery.deliver(BIG, links)
    assert clock.now - start == pytest.approx(delivery.PATIENCE)
    assert all(link.stalled for link in links)
    for _ in range(10):
        delivery.deliver(BIG, links)
    assert clock.now - start == pytest.approx(delivery.PATIENCE)


def test_others_have_the_message_before_a_full_receiver_is_waited_for(pairs, clock):
    full, _ = pairs()
    full.send(BIG, socket.MSG_DONTWAIT)
    ours, theirs = pairs()
    seen = []

    def look(milliseconds):
        seen.append(read_all(theirs))
        clock.now += milliseconds / 1000
        return []

    clock.wait = look
    delivery.deliver(
        b"news", [delivery.Link(name, s, clock) for name, s in (("f", full), ("g", ours))]
    )
    assert seen == [b"news"]


def test_receiver_that_was_back_lately_is_not_waited_for(pairs, clock, unwatched):
    ours, theirs = pairs()
    link = delivery.Link("slow", ours, threading.RLock())

    def stall():
        start = clock.now
        delivery.deliver(BIG, [link])
        assert link.stalled
        waited = clock.now - start
        while not link.flush():
            read_all(theirs)
        read_all(theirs)
        assert not link.stalled
        return waited

    assert stall() == pytest.approx(delivery.PATIENCE)
    assert stall() == 0.0
    clock.now += delivery.PROBATION
    assert stall() == pytest.approx(delivery.PATIENCE)
    assert unwatched == [link] * 3


def test_receiver_that_reads_in_time_loses_nothing(pairs, unwatched, monkeypatch):
    monkeypatch.setattr(delivery, "PATIENCE", TIME_OUT)
    ours, theirs = pairs()
    link = delivery.Link("reader", ours, threading.RLock())
    messages = [packet(number, 100_000) for number in range(20)]
    received = []
    size = sum(map(len, messages))
    reader = threading.Thread(target=lambda: received.append(receive(theirs, size)))
    reader.start()
    for message in messages:
        delivery.deliver(message, [link])
    reader.join(TIME_OUT)
    assert unpack(received[0]) == list(range(20))
    assert (link.sent, link.lost, unwatched) == (20, 0, [])


def test_stalled_receiver_is_served_in_the_background_until_it_is_back(pairs, monkeypatch):
    monkeypatch.setattr(delivery, "REPORT_PERIOD", 0.0)
    threads = threading.active_count()
    ours, theirs = pairs()
    link = RecordingLink(ours)
    messages = [packet(number, 300_000) for number in range(5)]
    for message in messages:
        with link.lock:
            delivery.deliver(message, [link])
    assert link.stalled
    assert threading.active_count() == threads + 1
    wait_until(lambda: link.reports)
    stream = receive(theirs, len(messages[0]) + len(messages[-1]))
    wait_until(lambda: threading.active_count() == threads)
    assert unpack(stream) == [0, 4]
    assert (link.sent, link.lost, link.stalled) == (2, 3, False)
    assert [stalled for stalled, _ in link.reports] == [True] * (len(link.reports) - 1) + [False]
    assert sum(lost for _, lost in link.reports) == 3


def test_background_thread_serves_a_second_stall(pairs):
    threads = threading.active_count()
    for _ in range(2):
        ours, theirs = pairs()
        link = RecordingLink(ours)
        with link.lock:
            delivery.deliver(BIG, [link])
        assert receive(theirs, len(BIG)) == BIG
        wait_until(lambda: threading.active_count() == threads)


@pytest.mark.parametrize("stalled", [False, True])
def test_receiver_that_has_gone_is_dropped_without_a_word(pairs, stalled):
    threads = threading.active_count()
    ours, theirs = pairs()
    link = RecordingLink(ours)
    with link.lock:
        if stalled:
            delivery.deliver(BIG, [link])
            theirs.close()
        else:
            theirs.close()
            delivery.deliver(b"news", [link])
    wait_until(lambda: link.fileno() == -1)
    wait_until(lambda: threading.active_count() == threads)
    with link.lock:
        delivery.deliver(b"more", [link])
    assert link.reports == []


def test_socket_closed_by_someone_else_ends_the_background_thread(pairs):
    threads = threading.active_count()
    ours, _ = pairs()
    link = RecordingLink(ours)
    with link.lock:
        delivery.deliver(BIG, [link])
    ours.close()
    wait_until(lambda: threading.active_count() == threads)


def test_reports_are_throttled_and_complete(pairs):
    link = RecordingLink(pairs()[0])
    assert link.settle(100.0), "nothing to tell"
    link.stalled = True
    assert not link.settle(100.0)
    assert link.reports == [], "no loss yet"
    link.lost = 7
    assert not link.settle(101.0)
    link.lost = 9
    assert not link.settle(101.0 + 0.9 * delivery.REPORT_PERIOD)
    assert link.reports == [(True, 7)]
    assert not link.settle(101.0 + delivery.REPORT_PERIOD)
    assert link.reports == [(True, 7), (True, 2)]
    link.lost, link.stalled = 10, False
    assert link.settle(102.0 + delivery.REPORT_PERIOD)
    assert link.reports == [(True, 7), (True, 2), (False, 1)]
    link.lost = 11
    assert not link.settle(103.0 + delivery.REPORT_PERIOD), "a loss yet to be told"
    assert link.settle(102.0 + 2 * delivery.REPORT_PERIOD)
    assert link.reports[3:] == [(False, 1)]
