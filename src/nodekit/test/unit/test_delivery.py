"""Tests of delivery over real sockets, without ROS, with receivers that do not read."""

import contextlib
import errno
import os
import select
import socket
import struct
import threading
import time
import types

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit.testing.waiting import wait_until
from nodekit.transport import delivery, subscriber_connection
from nodekit.transport.subscriber_connection import (
    PROBATION_S,
    REPORT_PERIOD_S,
    STALL_S,
    LossReports,
    Phase,
    SubscriberConnection,
)

TIME_OUT = 20.0  # s
BIG = b"b" * 1_000_000  # more than a pair's buffers take


class RecordingLink(SubscriberConnection):
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
    # That of a test before may still be about to end, and would use a replaced clock.
    wait_until(lambda: delivery._drain._thread is None, lambda: str(delivery._drain._links))
    links = []
    monkeypatch.setattr(delivery, "_drain", types.SimpleNamespace(watch=links.extend))
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
    """Parse a received stream; an assertion fails for an incomplete message."""
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


@given(
    st.lists(
        st.one_of(
            st.tuples(st.just("offer"), st.integers(0, 30_000), st.integers(1, 3)),
            st.tuples(st.just("read"), st.integers(1, 20_000), st.just(0)),
            st.tuples(st.just("flush"), st.just(0), st.just(0)),
        ),
        max_size=60,
    ),
    st.sampled_from([None, 1, 3, 10]),
)
def test_messages_are_whole_in_order_and_accounted_for(steps, depth):
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        theirs.setblocking(False)
        link = RecordingLink(ours)
        link.depth = depth
        received, offered = b"", 0
        for step, size, count in steps:
            if step == "offer":
                together = b"".join(packet(offered + each, size) for each in range(count))
                if link.stalled:
                    waiting = sum(each.messages for each in link.held if not each.has_begun)
                    lost = link.lost
                    link.hold(together, count)
                    if waiting + count <= (depth or 1):
                        assert link.lost == lost, "so many may wait"
                    assert sum(
                        each.messages for each in list(link.held)[:-1] if not each.has_begun
                    ) <= max(0, (depth or 1) - count)
                elif not link.send(together, count):
                    link.stall()
                offered += count
            elif step == "flush":
                link.flush(0.0)
            else:
                with contextlib.suppress(BlockingIOError):
                    received += theirs.recv(size)
        while not link.flush(0.0):
            received += read_all(theirs)
        received += read_all(theirs)
    assert link.sent_bytes == len(received)
    numbers = unpack(received)
    assert numbers == sorted(set(numbers))
    assert numbers[-1:] == list(range(offered))[-1:], "the last message always arrives"
    assert len(numbers) == link.sent == offered - link.lost
    assert not link.stalled


def test_full_receivers_together_are_waited_for_once(pairs, clock):
    links = [SubscriberConnection("full", pairs()[0], threading.RLock()) for _ in range(20)]
    start = clock.now
    delivery.deliver(BIG, links)
    assert clock.now - start == pytest.approx(delivery.PATIENCE_S)
    assert all(link.stalled for link in links)
    for _ in range(10):
        delivery.deliver(BIG, links)
    assert clock.now - start == pytest.approx(delivery.PATIENCE_S)


def test_receiver_that_catches_up_does_not_end_the_wait_for_another(pairs, clock, monkeypatch):
    (ours, theirs), (others, _) = pairs(), pairs()
    quick, full = (SubscriberConnection("r", one, threading.RLock()) for one in (ours, others))
    behind = [ours.fileno()]

    def poll(milliseconds):
        if behind and read_all(theirs):
            clock.now += 1e-4
            return [(ours.fileno(), select.POLLOUT)]
        return clock.wait(milliseconds)

    poller = types.SimpleNamespace(register=lambda *_: None, unregister=behind.remove, poll=poll)
    monkeypatch.setattr(clock, "poll", lambda: poller)
    start = clock.now
    delivery.deliver(BIG, [quick, full])
    assert (quick.sent, quick.stalled, full.sent, full.stalled) == (1, False, 0, True)
    assert clock.now - start == pytest.approx(delivery.PATIENCE_S)


def test_lost_batch_counts_all_its_messages(pairs, clock):
    link = SubscriberConnection("full", pairs()[0], threading.RLock())
    for _ in range(20):
        delivery.deliver(BIG, [link], 3)
    held = sum(each.messages for each in link.held)
    assert (link.sent, held, link.lost) == (0, 6, 54)


def test_receiver_with_a_depth_is_not_waited_for_and_loses_only_the_excess(pairs, clock):
    start = clock.now
    ours, theirs = pairs()
    link = SubscriberConnection("full", ours, threading.RLock(), depth=10)
    for number in range(11):  # one is partly sent
        delivery.deliver(packet(number, 100_000), [link])
    assert (clock.now, link.lost) == (start, 0)
    for number in range(11, 14):
        delivery.deliver(packet(number, 100_000), [link])
    assert (clock.now, link.lost) == (start, 3)
    received = b""
    while not link.flush(clock.now):
        received += read_all(theirs)
    assert unpack(received + read_all(theirs)) == [0, *range(4, 14)]


def test_held_data_is_bounded_in_bytes_and_the_newest_is_always_held(pairs, monkeypatch, clock):
    monkeypatch.setattr("nodekit.transport.subscriber_connection.MOST_HELD", 3 * (len(BIG) + 500))
    link = SubscriberConnection("full", pairs()[0], threading.RLock(), depth=100)
    for _ in range(10):
        delivery.deliver(BIG, [link])
    assert (len(link.held), link.lost) == (3, 7)
    delivery.deliver(5 * BIG, [link])
    assert ([each.size for each in link.held], link.lost) == ([len(BIG), 5 * len(BIG)], 9)


def test_many_small_messages_are_bounded_by_their_memory(pairs, monkeypatch):
    monkeypatch.setattr("nodekit.transport.subscriber_connection.MOST_HELD", len(BIG) + 100_000)
    link = SubscriberConnection("full", pairs()[0], threading.RLock(), depth=1_000_000)
    delivery.deliver(BIG, [link])
    for _ in range(1000):
        delivery.deliver(b"small", [link])
    assert len(link.held) < 300


def test_flush_of_many_messages_returns_before_all_are_sent(pairs, clock):
    ours, theirs = pairs()
    link = SubscriberConnection("back", ours, threading.RLock(), depth=1_000_000)
    delivery.deliver(BIG, [link])
    for _ in range(1000):
        delivery.deliver(b"small", [link])
    read_all(theirs)
    while link.held[0].size == len(BIG):
        assert not link.flush(clock.now)
        read_all(theirs)
    assert not link.flush(clock.now)
    assert len(link.held) > 500


def test_receiver_that_takes_data_has_not_stalled(pairs, clock):
    ours, theirs = pairs()
    link = SubscriberConnection("slow", ours, threading.RLock(), depth=2)
    link._took_data_at = clock.now
    delivery.deliver(BIG, [link])
    for _ in range(10):
        clock.now += 0.9 * STALL_S
        read_all(theirs)
        assert not link.flush(clock.now)
        assert not link.takes_nothing(clock.now)
    clock.now += 1.1 * STALL_S
    assert link.takes_nothing(clock.now)


@pytest.mark.parametrize("reads", [True, False])
def test_closing_topic_waits_only_for_a_receiver_that_takes_data(pairs, monkeypatch, reads):
    monkeypatch.setattr(delivery, "CLOSING_PATIENCE_S", TIME_OUT)
    if reads:
        monkeypatch.setattr(subscriber_connection, "CLOSING_STALL_S", TIME_OUT)
    ours, theirs = pairs()
    link = SubscriberConnection("slow", ours, threading.RLock(), depth=2)
    for number in range(3):
        delivery.deliver(packet(number, len(BIG)), [link])
    reader = threading.Thread(target=receive, args=(theirs, 3 * len(packet(0, len(BIG)))))
    if reads:
        reader.start()
    began = time.monotonic()
    assert delivery.finish([link]) == ([] if reads else [link])
    assert time.monotonic() - began < TIME_OUT / 2
    assert link.unsent_messages == (0 if reads else 3)
    size = len(packet(0, len(BIG)))
    assert (link.unsent_bytes == 0) if reads else (3 * size <= link.unsent_bytes < 4 * size)
    if reads:
        reader.join(TIME_OUT)
        assert not reader.is_alive()


def test_topics_closed_together_share_one_time_limit(monkeypatch):
    now = [1000.0]
    sleep = types.SimpleNamespace(
        monotonic=lambda: now[0], sleep=lambda seconds: now.__setitem__(0, now[0] + seconds)
    )
    monkeypatch.setattr(delivery, "time", sleep)
    slow = types.SimpleNamespace(held=[b"data"], takes_held_data=lambda now: True)
    for _ in range(2):  # each context has its own limit
        began = now[0]
        with delivery.closing_together():
            with delivery.closing_together():
                assert delivery.finish([slow]) == [slow]
            assert [delivery.finish([slow]) for _ in range(3)] == 3 * [[slow]]
        assert now[0] - began == pytest.approx(delivery.CLOSING_PATIENCE_S, abs=0.1)
    began = now[0]
    for _ in range(3):
        delivery.finish([slow])
    assert now[0] - began == pytest.approx(3 * delivery.CLOSING_PATIENCE_S, abs=0.1)


def test_receiver_is_served_immediately_while_another_is_watched(pairs, monkeypatch):
    monkeypatch.setattr(delivery, "DRAIN_PERIOD_S", 10 * TIME_OUT)
    deaf = SubscriberConnection("deaf", pairs()[0], threading.RLock(), depth=1)
    with deaf.lock:
        delivery.deliver(BIG, [deaf])
    ours, theirs = pairs()
    reads = SubscriberConnection("reads", ours, threading.RLock(), depth=1)
    with reads.lock:
        delivery.deliver(BIG, [reads])
    assert receive(theirs, len(BIG)) == BIG
    deaf.drop()
    delivery._drain.watch([deaf])  # wakes the thread, which ends then


def test_background_thread_outlives_a_defect_of_its_own(pairs, monkeypatch):
    monkeypatch.setattr(delivery, "DRAIN_PERIOD_S", 0.01)
    ours, theirs = pairs()
    link = SubscriberConnection("reads", ours, threading.RLock(), depth=1)
    failed = threading.Event()
    serve = delivery._drain._writable

    def fail_once(links):
        if failed.is_set():
            return serve(links)
        failed.set()
        raise OSError("a defect")

    monkeypatch.setattr(delivery._drain, "_writable", fail_once)
    with link.lock:
        delivery.deliver(BIG, [link])
    assert failed.wait(TIME_OUT)
    assert receive(theirs, len(BIG)) == BIG


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
        b"news", [SubscriberConnection(name, s, clock) for name, s in (("f", full), ("g", ours))]
    )
    assert seen == [b"news"]


def test_receiver_that_was_back_lately_is_not_waited_for(pairs, clock, unwatched):
    ours, theirs = pairs()
    link = SubscriberConnection("slow", ours, threading.RLock())

    def stall():
        start = clock.now
        delivery.deliver(BIG, [link])
        assert link.stalled
        waited = clock.now - start
        while not link.flush(clock.now):
            read_all(theirs)
        read_all(theirs)
        assert not link.stalled
        return waited

    assert stall() == pytest.approx(delivery.PATIENCE_S)
    assert stall() == 0.0
    clock.now += PROBATION_S
    assert stall() == pytest.approx(delivery.PATIENCE_S)
    assert unwatched == [link] * 3


def test_receiver_that_reads_in_time_loses_nothing(pairs, unwatched, monkeypatch):
    monkeypatch.setattr(delivery, "PATIENCE_S", TIME_OUT)
    ours, theirs = pairs()
    link = SubscriberConnection("reader", ours, threading.RLock())
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
    monkeypatch.setattr("nodekit.transport.subscriber_connection.REPORT_PERIOD_S", 0.0)
    threads = threading.active_count()
    ours, theirs = pairs()
    link = RecordingLink(ours)
    messages = [packet(number, 300_000) for number in range(5)]
    for message in messages:
        with link.lock:
            delivery.deliver(message, [link])
    assert link.stalled
    assert threading.active_count() == threads + 1
    wait_until(lambda: link.reports, lambda: "no report")
    stream = receive(theirs, len(messages[0]) + len(messages[-1]))
    wait_until(lambda: threading.active_count() == threads, lambda: "a thread is left")
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
        wait_until(lambda: threading.active_count() == threads, lambda: "a thread is left")


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
    wait_until(lambda: link.fileno() == -1, lambda: "the link is open")
    wait_until(lambda: threading.active_count() == threads, lambda: "a thread is left")
    with link.lock:
        delivery.deliver(b"more", [link])
    assert link.reports == []


def test_send_returns_whether_all_was_sent_or_the_peer_is_gone(pairs):
    ours, theirs = pairs()
    link = RecordingLink(ours)
    assert link.send(b"news", 1)
    theirs.close()
    assert link.send(b"more", 1)
    assert (link.phase, list(link.held), link.sent) == (Phase.GONE, [], 1)


def test_socket_closed_by_someone_else_ends_the_background_thread(pairs):
    threads = threading.active_count()
    ours, _ = pairs()
    link = RecordingLink(ours)
    with link.lock:
        delivery.deliver(BIG, [link])
    ours.close()
    wait_until(lambda: threading.active_count() == threads, lambda: "a thread is left")


def test_reports_are_throttled_and_complete(pairs):
    link = RecordingLink(pairs()[0])

    def is_done(now):
        link.report_if_due(now)
        return not link.needs_attention()

    assert is_done(100.0), "nothing to tell"
    link.phase = Phase.STALLED
    assert not is_done(100.0)
    assert link.reports == [], "no loss yet"
    link.lost = 7
    assert not is_done(101.0)
    link.lost = 9
    assert not is_done(101.0 + 0.9 * REPORT_PERIOD_S)
    assert link.reports == [(True, 7)]
    assert not is_done(101.0 + REPORT_PERIOD_S)
    assert link.reports == [(True, 7), (True, 2)]
    link.lost, link.phase = 10, Phase.ON_PROBATION
    assert is_done(102.0 + REPORT_PERIOD_S)
    assert link.reports == [(True, 7), (True, 2), (False, 1)]
    link.lost = 11
    assert not is_done(103.0 + REPORT_PERIOD_S), "a loss yet to be told"
    assert is_done(102.0 + 2 * REPORT_PERIOD_S)
    assert link.reports[3:] == [(False, 1)]


def test_types_of_report_are_throttled_separately():
    reports = LossReports()
    steps = [  # s, stalled, lost in all, report
        (0.0, True, 0, None),  # a stall without loss
        (0.0, False, 0, None),  # ... and its end are not reported
        (1.0, True, 3, 3),
        (2.0, False, 3, 0),  # the end of a reported stall
        (3.0, False, 3, None),
        (4.0, True, 5, None),
        (5.0, False, 5, None),
        (1.0 + REPORT_PERIOD_S, True, 6, 3),
        (1.5 + REPORT_PERIOD_S, False, 6, None),
        (2.0 + REPORT_PERIOD_S, False, 6, 0),
    ]
    for now, stalled, lost, told in steps:
        assert reports.take_due(stalled, lost, now) == told, now
    assert not reports.is_pending(False, 6)


def test_phases_of_a_receiver(pairs, clock):
    ours, theirs = pairs()
    link = RecordingLink(ours)
    seen = []

    def note():
        if seen[-1:] != [link.phase]:
            seen.append(link.phase)

    def wait(milliseconds):
        note()
        clock.now += milliseconds / 1000
        return []

    def fill_and_empty():
        delivery.deliver(BIG, [link])
        note()
        while not link.flush(clock.now):
            read_all(theirs)
        note()
        read_all(theirs)

    clock.wait = wait
    note()
    fill_and_empty()
    fill_and_empty()
    clock.now += PROBATION_S
    fill_and_empty()
    theirs.close()
    delivery.deliver(b"news", [link])
    note()
    stalled_and_back = [Phase.STALLED, Phase.ON_PROBATION]
    assert seen == [
        *(Phase.KEEPING_UP, Phase.WAITED_FOR, *stalled_and_back),
        *stalled_and_back,
        *(Phase.WAITED_FOR, *stalled_and_back),
        Phase.GONE,
    ]


def test_probation_ends_with_a_wait_that_is_not_in_vain(pairs, clock):
    ours, theirs = pairs()
    link = RecordingLink(ours)
    delivery.deliver(BIG, [link])
    while not link.flush(clock.now):
        read_all(theirs)
    read_all(theirs)
    assert link.phase is Phase.ON_PROBATION
    clock.now += PROBATION_S

    def read(milliseconds):
        read_all(theirs)
        return [(ours.fileno(), select.POLLOUT)]

    clock.poll = lambda: types.SimpleNamespace(
        register=lambda *args: None, unregister=lambda descriptor: None, poll=read
    )
    delivery.deliver(BIG, [link])
    assert (link.phase, list(link.held), link.sent) == (Phase.KEEPING_UP, [], 2)


@pytest.mark.parametrize("lost", [0, 2])
def test_receiver_that_closes_while_messages_are_held_back(pairs, clock, unwatched, lost):
    ours, theirs = pairs()
    link = RecordingLink(ours)
    for _ in range(2 + lost):
        delivery.deliver(BIG, [link])
    assert [item.has_begun for item in link.held] == [True, False]
    theirs.close()
    assert link.flush(clock.now), "nothing is held back any more"
    assert (link.phase, list(link.held), link.fileno()) == (Phase.GONE, [], -1)
    for _ in range(3):
        delivery.deliver(BIG, [link])
    assert (link.sent, link.sent_bytes, link.lost) == (0, 0, lost)
    assert not link.held
    assert not link.needs_attention()
    link.report_if_due(clock.now)
    assert link.reports == []
    assert unwatched == [link]


def test_delivery_that_is_interrupted_tears_no_message(pairs, clock, unwatched):
    ours, theirs = pairs()
    link = RecordingLink(ours)

    def interrupt(milliseconds):
        raise KeyboardInterrupt

    clock.wait = interrupt
    messages = [packet(number, 300_000) for number in range(3)]
    with pytest.raises(KeyboardInterrupt):
        delivery.deliver(messages[0], [link])
    assert (link.phase, unwatched) == (Phase.STALLED, [link])
    for message in messages[1:]:
        delivery.deliver(message, [link])
    stream = b""
    while not link.flush(clock.now):
        stream += read_all(theirs)
    assert unpack(stream + read_all(theirs)) == [0, 2]
    assert (link.sent, link.lost) == (2, 1)


class FullSocket:
    """A socket that is said to be writable and takes nothing, as when memory is short."""

    def __init__(self, sock):
        self._sock = sock
        self.tries = []

    def fileno(self):
        return self._sock.fileno()

    def send(self, data, flags):
        self.tries.append(time.monotonic())
        raise BlockingIOError

    def close(self):
        self._sock.close()


def test_background_thread_pauses_if_a_writable_socket_accepts_nothing(pairs):
    threads = threading.active_count()
    ours, _ = pairs()
    full = FullSocket(ours)
    link = RecordingLink(full)
    with link.lock:
        delivery.deliver(b"news", [link])
    full.tries.clear()
    wait_until(lambda: len(full.tries) > 20, lambda: "too few tries")
    assert full.tries[20] - full.tries[0] >= 20 * delivery.DRAIN_PAUSE_S
    ours.close()
    wait_until(lambda: threading.active_count() == threads, lambda: "a thread is left")


def test_background_thread_notices_another_stall(pairs):
    threads = threading.active_count()
    (first, held), (second, read) = pairs(), pairs()
    silent, other = RecordingLink(first), RecordingLink(second)
    with silent.lock:
        delivery.deliver(BIG, [silent])
    time.sleep(delivery.DRAIN_PERIOD_S / 2)  # it polls the first one only by now
    with other.lock:
        delivery.deliver(BIG, [other])
    assert receive(read, len(BIG)) == BIG
    wait_until(lambda: other.phase is Phase.ON_PROBATION, lambda: "it is not on probation")
    assert (silent.phase, threading.active_count()) == (Phase.STALLED, threads + 1)
    held.close()
    wait_until(lambda: threading.active_count() == threads, lambda: "a thread is left")


class LockWithEvent:
    """A lock; something happens just before it is taken for the next time."""

    def __init__(self, event):
        self._lock = threading.RLock()
        self._event = event

    def __enter__(self):
        event, self._event = self._event, lambda: None
        event()
        self._lock.acquire()

    def __exit__(self, *args):
        self._lock.release()


def test_receiver_that_stalls_again_while_it_is_let_go_is_watched_further(pairs, monkeypatch):
    drain = delivery._Drain()
    drain._open_pipe()
    drain._thread = threading.current_thread()  # as if it ran
    monkeypatch.setattr(delivery, "_drain", drain)
    monkeypatch.setattr(delivery, "DRAIN_PERIOD_S", 0.0)
    link = RecordingLink(pairs()[0])
    drain._links.add(link)
    drain._lock = LockWithEvent(lambda: delivery.deliver(BIG, [link]))
    drain._serve([link])
    assert link.stalled
    assert drain._links == {link}


def test_receiver_that_is_back_is_let_go(monkeypatch, pairs):
    drain = delivery._Drain()
    drain._open_pipe()
    monkeypatch.setattr(delivery, "DRAIN_PERIOD_S", 0.0)
    link = RecordingLink(pairs()[0])
    link.phase = Phase.ON_PROBATION
    drain._links.add(link)
    drain._serve([link])
    assert drain._links == set()


def test_socket_closed_by_someone_else_with_a_report_pending_ends_the_background_thread(pairs):
    threads = threading.active_count()
    ours, theirs = pairs()
    link = RecordingLink(ours)
    link.lost = 1
    link.report_if_due(time.monotonic())  # so that the next report of a return has to wait
    with link.lock:
        for _ in range(3):
            delivery.deliver(BIG, [link])
    wait_until(lambda: len(link.reports) == 2, lambda: "no second report")
    receive(theirs, 2 * len(BIG))
    wait_until(lambda: link.phase is Phase.ON_PROBATION, lambda: "it is not on probation")
    assert link.needs_attention()
    time.sleep(10 * delivery.DRAIN_PAUSE_S)
    assert threading.active_count() == threads + 1
    ours.close()
    wait_until(lambda: threading.active_count() == threads, lambda: "a thread is left")
    assert link.phase is Phase.GONE
    assert link.reports == [(False, 1), (True, 1)]


def test_report_that_fails_does_not_end_the_background_thread(pairs, caplog):
    threads = threading.active_count()
    ours, theirs = pairs()
    link = RecordingLink(ours)
    failed = threading.Event()

    def fail(stalled, lost):
        failed.set()
        raise ValueError("no report")

    link.report = fail
    with link.lock:
        for _ in range(3):
            delivery.deliver(BIG, [link])
    assert failed.wait(TIME_OUT)
    assert receive(theirs, 2 * len(BIG)) == 2 * BIG
    wait_until(lambda: threading.active_count() == threads, lambda: "a thread is left")
    assert (link.phase, link.sent, link.lost) == (Phase.ON_PROBATION, 2, 1)
    assert "receiver: delivery failed" in caplog.text
    assert "no report" in caplog.text


def test_background_thread_needs_no_free_descriptor(pairs, monkeypatch):
    def fail(flags):
        raise OSError(errno.EMFILE, "Too many open files")

    threads = threading.active_count()
    (first, one), (second, two) = pairs(), pairs()
    with monkeypatch.context() as patch:
        patch.setattr(os, "pipe2", fail)
        delivery.deliver(BIG, [RecordingLink(first)])
        delivery.deliver(BIG, [RecordingLink(second)])
    for theirs in (two, one):
        assert receive(theirs, len(BIG)) == BIG
    wait_until(lambda: threading.active_count() == threads, lambda: "a thread is left")


def test_background_thread_that_cannot_be_started_is_started_at_the_next_stall(pairs, monkeypatch):
    def fail(thread):
        raise RuntimeError("can't start new thread")

    threads = threading.active_count()
    (first, one), (second, two) = pairs(), pairs()
    links = [RecordingLink(first), RecordingLink(second)]
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", fail)
        with pytest.raises(RuntimeError):
            delivery.deliver(BIG, links[:1])
    delivery.deliver(BIG, links[1:])
    for theirs in (one, two):
        assert receive(theirs, len(BIG)) == BIG
    wait_until(lambda: threading.active_count() == threads, lambda: "a thread is left")
