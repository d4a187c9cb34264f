"""Delivery of messages over stream sockets; a receiver cannot block the others.

Messages are sent from the caller's own thread. Data that a receiver's socket does not accept is
held and sent by a background thread, see :mod:`nodekit.transport.subscriber_connection`:
immediately if its connection has a depth, otherwise after one wait of up to :data:`PATIENCE_S`. The
thread exists only while data is held.

A delivery holds one or more messages: they share a system call, which takes longer than all other
work for a small message.
"""

import contextlib
import logging
import math
import os
import select
import threading
import time
from typing import Dict, Iterable, Iterator, List, Optional, Sequence, Set

from nodekit.transport.subscriber_connection import SubscriberConnection

#: Longest wait of one delivery for all its receivers together [s].
PATIENCE_S = 0.05
#: Longest wait for the receivers of a closing topic, if they take data [s]; time between checks.
CLOSING_PATIENCE_S = 2.0
CLOSING_PERIOD_S = 0.005
#: Longest time between two checks of stalled receivers for closed sockets and reports [s].
DRAIN_PERIOD_S = 0.1
#: Pause of the background thread [s]: a socket short of memory is "writable" but accepts nothing.
DRAIN_PAUSE_S = 0.001


def deliver(data: bytes, links: Iterable[SubscriberConnection], messages: int = 1) -> None:
    """Send messages to every receiver; wait at most :data:`PATIENCE_S` for full sockets.

    :param data: serialized messages, concatenated
    :param links: connections to the receivers; the caller holds their lock
    :param messages: number of messages
    """
    serve_later(send_to_all(data, links, messages))


def send_to_all(
    data: bytes, links: Iterable[SubscriberConnection], messages: int = 1
) -> List[SubscriberConnection]:
    """Send messages to every receiver without waiting.

    :param data: serialized messages, concatenated
    :param links: connections to the receivers; the caller holds their lock
    :param messages: number of messages
    :returns: connections for :func:`serve_later`
    """
    full = []
    for link in links:
        if link.held:
            link.hold(data, messages)
        elif not link.send(data, messages):
            full.append(link)
    return full


def serve_later(full: List[SubscriberConnection]) -> None:
    """Wait at most :data:`PATIENCE_S` for receivers, then serve them in the background.

    :param full: connections that hold data; the caller holds their lock
    """
    if full:
        try:
            _wait(full)
        finally:  # also if a signal handler raises: otherwise held data would never be sent
            _mark_stalled([link for link in full if link.held])


class _Closing(threading.local):
    """Time limit shared by the topics that a thread closes together."""

    is_together = False
    deadline = math.inf


_CLOSING = _Closing()


@contextlib.contextmanager
def closing_together() -> Iterator[None]:
    """Share one time limit among all topics that this thread closes in the context."""
    if _CLOSING.is_together:  # nested: a resource of an owner is an owner itself
        yield
        return
    _CLOSING.is_together, _CLOSING.deadline = True, math.inf
    try:
        yield
    finally:
        _CLOSING.is_together = False


def finish(links: Sequence[SubscriberConnection]) -> List[SubscriberConnection]:
    """Wait until held data is sent, at most :data:`CLOSING_PATIENCE_S`, if receivers take it.

    :param links: connections to the receivers of a topic that is about to close, without their lock
    :returns: connections with unsent data
    """
    deadline = time.monotonic() + CLOSING_PATIENCE_S
    if _CLOSING.is_together:
        deadline = _CLOSING.deadline = min(deadline, _CLOSING.deadline)
    now = 0.0
    while now < deadline:
        now = time.monotonic()
        if not any(link.takes_held_data(now) for link in links):
            break
        time.sleep(CLOSING_PERIOD_S)
    return [link for link in links if link.held]


def _wait(full: List[SubscriberConnection]) -> None:
    now = time.monotonic()
    deadline = now + PATIENCE_S
    poller = select.poll()
    waiting: Dict[int, SubscriberConnection] = {}
    for link in full:
        descriptor, events = link.awaited()
        if descriptor >= 0 and link.begin_wait(now):
            poller.register(descriptor, events)
            waiting[descriptor] = link
    while waiting and now < deadline:
        for descriptor, _ in poller.poll(1000 * (deadline - now)):
            if waiting[descriptor].flush(now):
                poller.unregister(descriptor)
                del waiting[descriptor]
        now = time.monotonic()


def _mark_stalled(links: List[SubscriberConnection]) -> None:
    for link in links:
        link.stall()
    _drain.watch(links)


class _Drain:
    """Background service of all stalled receivers, in a thread that ends with the last one."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._links: Set[SubscriberConnection] = set()
        self._thread: Optional[threading.Thread] = None
        #: Ends of a pipe that wakes the thread up; it exists as long as the thread does. -1 without
        #: a free descriptor: the thread then looks every :data:`DRAIN_PERIOD_S`.
        self._wake_out = self._wake_in = -1

    def watch(self, links: List[SubscriberConnection]) -> None:
        with self._lock:
            self._links.update(links)
            if self._thread is None:
                if self._links:
                    self._start()
            elif self._wake_in >= 0:
                with contextlib.suppress(BlockingIOError):  # the pipe is full: it wakes up anyway
                    os.write(self._wake_in, b"1")

    def _open_pipe(self) -> None:
        with contextlib.suppress(OSError):
            self._wake_out, self._wake_in = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)

    def _start(self) -> None:
        thread = threading.Thread(target=self._run, name="drain", daemon=True)
        self._open_pipe()
        try:
            thread.start()  # may fail; the next stall retries
        except BaseException:
            self._close_pipe()
            raise
        self._thread = thread

    def _close_pipe(self) -> None:
        if self._wake_in >= 0:
            os.close(self._wake_out)
            os.close(self._wake_in)
            self._wake_out = self._wake_in = -1

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._links:
                    self._thread = None
                    self._close_pipe()
                    return
                links = list(self._links)
            try:
                self._serve(links)
            except Exception:  # without the thread, held data would never be sent
                logging.getLogger(__name__).exception("delivery in the background failed")
                time.sleep(DRAIN_PERIOD_S)

    def _serve(self, links: List[SubscriberConnection]) -> None:
        for link in self._writable(links):
            with _errors_logged(link), link.lock:
                if link.stalled:
                    link.flush(time.monotonic())
        time.sleep(DRAIN_PAUSE_S)
        now = time.monotonic()
        for link in links:
            with _errors_logged(link):
                if link.fileno() < 0:  # closed by another owner of the socket
                    with link.lock:
                        link.drop()
                link.report_if_due(now)
            with self._lock:  # otherwise a link that stalls again now would be lost
                if not link.needs_attention():
                    self._links.discard(link)

    def _writable(self, links: List[SubscriberConnection]) -> List[SubscriberConnection]:
        """Wait for the stalled links; return those that may be writable."""
        poller = select.poll()
        if self._wake_out >= 0:
            poller.register(self._wake_out, select.POLLIN)
        polled: Dict[int, SubscriberConnection] = {}
        for link in links:
            descriptor, events = link.awaited()
            if link.stalled and descriptor >= 0:
                poller.register(descriptor, events)
                polled[descriptor] = link
        ready = [descriptor for descriptor, _ in poller.poll(1000 * DRAIN_PERIOD_S)]
        if self._wake_out in ready:
            os.read(self._wake_out, 4096)
        return [polled[descriptor] for descriptor in ready if descriptor in polled]


@contextlib.contextmanager
def _errors_logged(link: SubscriberConnection) -> Iterator[None]:
    """Log exceptions of a link's ``close`` or ``report``; they must not end the thread."""
    try:
        yield
    except Exception:
        logging.getLogger(__name__).exception("%s: delivery failed", link.name)


_drain = _Drain()
