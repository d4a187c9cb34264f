"""Deliver messages over stream sockets so that no receiver can hold up the others.

A message goes out from the caller's own thread, without a queue: the shortest way there is. That
leaves the receiver that does not read. It is waited for once, for :data:`PATIENCE`; from then on
it counts as stalled, and a thread that exists only while there is such a receiver serves it in the
background. It costs two deliveries of memory at most: the unsent rest of one, which goes out before
anything else (a message is never torn), and the newest one, so that the last value of a slow
stream arrives. Those in between are lost, counted and reported.

A delivery is a message or several that are ready at once: they share a call of the kernel, which
takes longer than all else that is done for a small message.
"""

import select
import socket
import threading
import time
from typing import Any, ContextManager, Dict, Iterable, List, Optional, Set

#: longest time one delivery waits for all its receivers together, s
PATIENCE = 0.05
#: a receiver that has stalled is not waited for again until so long after its return, s
PROBATION = 10.0
#: shortest time between two reports of the same kind about the same receiver, s
REPORT_PERIOD = 10.0
#: longest time until the background thread takes notice of a newly stalled receiver, s
DRAIN_PERIOD = 0.1
#: pause of the background thread, as a socket short of memory is "writable" but takes nothing, s
DRAIN_PAUSE = 0.001


class Link:
    """The way to one receiver. Whoever calls a method that sends holds ``lock``.

    :param name: the receiver's name, for reports
    :param sock: connected stream socket
    :param lock: lock of everything that delivers to this link
    """

    def __init__(self, name: str, sock: Any, lock: ContextManager[Any]) -> None:
        self.name = name
        self.lock = lock
        #: messages, and their bytes, that have gone out as a whole; messages that were lost
        self.sent = self.sent_bytes = self.lost = 0
        self.stalled = False
        self._socket = sock
        self._rest: Optional[memoryview] = None  # of a delivery that is partly on the wire
        self._rest_messages = 0
        self._newest: Optional[bytes] = None  # a whole delivery, due after the rest
        self._newest_messages = 0
        self._patient_from = 0.0
        self._reported = 0
        self._warned = False
        self._quiet_until = {True: 0.0, False: 0.0}

    def drop(self) -> None:
        """Give the receiver up, as the other end is gone."""
        self._socket.close()

    def report(self, stalled: bool, lost: int) -> None:
        """Tell of a stalled receiver that loses messages, or of one that keeps up again.

        :param stalled: which of the two
        :param lost: messages lost since the last report
        """

    def fileno(self) -> int:
        """Tell the socket's descriptor.

        :returns: the descriptor, or -1 once the socket is closed
        """
        return int(self._socket.fileno())

    def send(self, data: bytes, messages: int) -> bool:
        """Send a delivery, as far as the socket takes it at once, when nothing is held back.

        :param data: the delivery
        :param messages: how many messages it holds
        :returns: whether nothing of it is held back now, also because the receiver has gone
        """
        try:
            size = self._socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            self._newest, self._newest_messages = data, messages
            return False
        except OSError:
            self.drop()
            return True
        if size != len(data):
            self._rest, self._rest_messages = memoryview(data)[size:], messages
            return False
        self.sent += messages
        self.sent_bytes += size
        return True

    def hold(self, data: bytes, messages: int) -> None:
        """Hold a delivery back for a stalled receiver, in place of an earlier one.

        :param data: the delivery
        :param messages: how many messages it holds
        """
        if self._newest is not None:
            self.lost += self._newest_messages
        self._newest, self._newest_messages = data, messages

    def flush(self) -> bool:
        """Send what is held back, as far as the socket takes it at once.

        :returns: whether nothing is held back any more; a stalled receiver is back then
        """
        try:
            if self._rest is not None:
                size = self._socket.send(self._rest, socket.MSG_DONTWAIT)
                if size != self._rest.nbytes:
                    self._rest = self._rest[size:]
                    return False
                self.sent += self._rest_messages
                self.sent_bytes += memoryview(self._rest.obj).nbytes
                self._rest = None
        except BlockingIOError:
            return False
        except OSError:
            self.drop()
        data, self._newest = self._newest, None
        if data is not None and not self.send(data, self._newest_messages):
            return False
        if self.stalled:
            self.stalled = False
            self._patient_from = time.monotonic() + PROBATION
        return True

    def is_waited_for(self, now: float) -> bool:
        """Tell whether the receiver has not stalled lately.

        :param now: monotonic time, s
        :returns: whether a delivery may wait for it
        """
        return now >= self._patient_from

    def stall(self) -> None:
        """Leave the receiver to the background thread until it reads again."""
        self.stalled = True
        _drain.watch(self)

    def settle(self, now: float) -> bool:
        """Report what is due.

        :param now: monotonic time, s
        :returns: whether the receiver needs no more attention
        """
        if self.fileno() < 0:
            self._rest = self._newest = None
            return True
        stalled, lost = self.stalled, self.lost - self._reported
        if not lost and (stalled or not self._warned):
            return not stalled
        if now < self._quiet_until[stalled]:
            return False
        self._quiet_until[stalled] = now + REPORT_PERIOD
        self._reported += lost
        self._warned = stalled
        self.report(stalled, lost)
        return not stalled


def deliver(data: bytes, links: Iterable[Link], messages: int = 1) -> None:
    """Send messages to every receiver; wait at most :data:`PATIENCE` for those that are full.

    :param data: the messages, one after the other, as they go on the wire
    :param links: where to; the caller holds their lock
    :param messages: how many there are
    """
    full = []
    for link in links:
        if link.stalled:
            link.hold(data, messages)
        elif not link.send(data, messages):
            full.append(link)
    if full:
        _wait(full)


def _wait(full: List[Link]) -> None:
    now = time.monotonic()
    deadline = now + PATIENCE
    poller = select.poll()
    waiting: Dict[int, Link] = {}
    for link in full:
        descriptor = link.fileno()
        if descriptor >= 0 and link.is_waited_for(now):
            poller.register(descriptor, select.POLLOUT)
            waiting[descriptor] = link
        else:
            link.stall()
    while waiting and now < deadline:
        for descriptor, _ in poller.poll(1000 * (deadline - now)):
            if waiting[descriptor].flush():
                poller.unregister(descriptor)
                del waiting[descriptor]
        now = time.monotonic()
    for link in waiting.values():
        link.stall()


class _Drain:
    """Serves all stalled receivers of the process, in a thread that ends with the last of them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._links: Set[Link] = set()
        self._thread: Optional[threading.Thread] = None

    def watch(self, link: Link) -> None:
        with self._lock:
            self._links.add(link)
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="drain", daemon=True)
                self._thread.start()

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._links:
                    self._thread = None
                    return
                links = list(self._links)
            self._flush(links)
            time.sleep(DRAIN_PAUSE)
            now = time.monotonic()
            for link in links:
                if link.settle(now):
                    with self._lock:
                        if not link.stalled or link.fileno() < 0:
                            self._links.discard(link)

    def _flush(self, links: List[Link]) -> None:
        poller = select.poll()
        polled: Dict[int, Link] = {}
        for link in links:
            descriptor = link.fileno()
            if link.stalled and descriptor >= 0:
                poller.register(descriptor, select.POLLOUT)
                polled[descriptor] = link
        for descriptor, _ in poller.poll(1000 * DRAIN_PERIOD):
            link = polled[descriptor]
            with link.lock:
                if link.stalled:
                    link.flush()


_drain = _Drain()
