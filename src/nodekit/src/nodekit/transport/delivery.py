"""Deliver messages over stream sockets so that no receiver can hold up the others.

A message goes out from the caller's own thread, without a queue: the shortest way there is. That
leaves the receiver that does not read. It is waited for once, for :data:`PATIENCE_S`; from then on
it counts as stalled, and a thread that exists only while there is such a receiver serves it in the
background, see :mod:`nodekit.transport.subscriber_connection`.

A delivery is a message or several that are ready at once: they share a call of the kernel, which
takes longer than all else that is done for a small message.
"""

import contextlib
import logging
import select
import threading
import time
from typing import Dict, Iterable, Iterator, List, Optional, Set

from nodekit.transport.subscriber_connection import SubscriberConnection

#: longest time one delivery waits for all its receivers together, s
PATIENCE_S = 0.05
#: longest time until the background thread takes notice of a newly stalled receiver, s
DRAIN_PERIOD_S = 0.1
#: pause of the background thread, as a socket short of memory is "writable" but takes nothing, s
DRAIN_PAUSE_S = 0.001


def deliver(data: bytes, links: Iterable[SubscriberConnection], messages: int = 1) -> None:
    """Send messages to every receiver; wait at most :data:`PATIENCE_S` for those that are full.

    :param data: the messages, one after the other, as they go on the wire
    :param links: where to; the caller holds their lock
    :param messages: how many there are
    """
    full = []
    for link in links:
        if link.held:
            link.hold(data, messages)
        elif not link.send(data, messages):
            full.append(link)
    if full:
        try:
            _wait(full)
        finally:  # also if a signal's handler raises: nobody else would send what is held back
            _mark_stalled([link for link in full if link.held])


def _wait(full: List[SubscriberConnection]) -> None:
    now = time.monotonic()
    deadline = now + PATIENCE_S
    poller = select.poll()
    waiting: Dict[int, SubscriberConnection] = {}
    for link in full:
        descriptor = link.fileno()
        if descriptor >= 0 and link.begin_wait(now):
            poller.register(descriptor, select.POLLOUT)
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
    """Serves all stalled receivers of the process, in a thread that ends with the last of them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._links: Set[SubscriberConnection] = set()
        self._thread: Optional[threading.Thread] = None

    def watch(self, links: List[SubscriberConnection]) -> None:
        with self._lock:
            self._links.update(links)
            if self._links and self._thread is None:
                thread = threading.Thread(target=self._run, name="drain", daemon=True)
                thread.start()  # may fail: then the next stall tries again
                self._thread = thread

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._links:
                    self._thread = None
                    return
                links = list(self._links)
            self._serve(links)

    def _serve(self, links: List[SubscriberConnection]) -> None:
        for link in self._writable(links):
            with _errors_logged(link), link.lock:
                if link.stalled:
                    link.flush(time.monotonic())
        time.sleep(DRAIN_PAUSE_S)
        now = time.monotonic()
        for link in links:
            with _errors_logged(link):
                if link.fileno() < 0:  # closed by whoever else has the socket
                    with link.lock:
                        link.drop()
                link.report_if_due(now)
            with self._lock:  # or else a link that stalls again just now would be forgotten
                if not link.needs_attention():
                    self._links.discard(link)

    def _writable(self, links: List[SubscriberConnection]) -> List[SubscriberConnection]:
        """Wait for the stalled ones of some links; return those that may take something."""
        poller = select.poll()
        polled: Dict[int, SubscriberConnection] = {}
        for link in links:
            descriptor = link.fileno()
            if link.stalled and descriptor >= 0:
                poller.register(descriptor, select.POLLOUT)
                polled[descriptor] = link
        return [polled[descriptor] for descriptor, _ in poller.poll(1000 * DRAIN_PERIOD_S)]


@contextlib.contextmanager
def _errors_logged(link: SubscriberConnection) -> Iterator[None]:
    """Log what a link's own ``close`` or ``report`` raises, as the others need the thread."""
    try:
        yield
    except Exception:
        logging.getLogger(__name__).exception("%s: delivery failed", link.name)


_drain = _Drain()
