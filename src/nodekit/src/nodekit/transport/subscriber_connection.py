"""Publisher's connection to one subscriber: sends messages, and holds or drops unread ones.

For a receiver that does not read, the rest of the partly sent delivery is held and sent first (a
message is never split), then the newest messages, up to the requested depth and :data:`MOST_HELD`.
Without a depth, only the newest delivery is held, so that the last value of a slow stream arrives.
Older deliveries are lost, counted and reported.
"""

import collections
import enum
import select
import socket
import time
from typing import Any, ContextManager, Deque, Optional, Tuple

#: After a stall, a receiver is not waited for again for this long [s].
PROBATION_S = 10.0
#: Most data that is held for a receiver, apart from the newest delivery [bytes]: forty pictures of
#: 1920 x 1080 pixels.
MOST_HELD = 256_000_000
#: Most deliveries that are sent in one go: publish() waits meanwhile.
MOST_AT_ONCE = 100
#: Memory of an empty delivery [bytes], measured with CPython 3.11.
_OVERHEAD = 400
#: A receiver that takes no data for this long has stalled [s]; when its topic closes, and it may
#: be at work on the message before.
STALL_S = 0.05
CLOSING_STALL_S = 0.2
#: Shortest time between two reports of the same type about the same receiver [s].
REPORT_PERIOD_S = 10.0


class Phase(enum.Enum):
    """Phase of a receiver. GONE may follow each phase, and is the last.

    ============  ==============================================  ============
    phase         event                                           next phase
    ============  ==============================================  ============
    KEEPING_UP    its socket is full                              WAITED_FOR
    WAITED_FOR    all held data is sent                           KEEPING_UP
    WAITED_FOR    the wait is over                                STALLED
    STALLED       all held data is sent                           ON_PROBATION
    ON_PROBATION  its socket is full within PROBATION_S           STALLED
    ON_PROBATION  its socket is full later                        WAITED_FOR
    ============  ==============================================  ============
    """

    #: accepts each delivery immediately
    KEEPING_UP = enum.auto()
    #: has time to read; its delivery may be partly sent
    WAITED_FOR = enum.auto()
    #: gets the held deliveries in the background
    STALLED = enum.auto()
    #: accepts each delivery immediately again, but has stalled before
    ON_PROBATION = enum.auto()
    #: the other end is closed
    GONE = enum.auto()


class Delivery:
    """Messages that are sent together, and their unsent data.

    :param data: the messages, concatenated
    :param messages: number of messages
    :param sent: amount of sent data [bytes]
    """

    __slots__ = ("messages", "size", "unsent")

    def __init__(self, data: bytes, messages: int, sent: int = 0) -> None:
        self.messages = messages
        self.size = len(data)
        self.unsent = memoryview(data)[sent:]

    @property
    def has_begun(self) -> bool:
        """Whether a part is sent, so that the rest has to follow."""
        return len(self.unsent) < self.size

    def prepare(self) -> None:
        """Prepare the next part for sending.

        :raises BlockingIOError: if that must wait; see :meth:`SubscriberConnection.awaited`
        :raises OSError: if the receiver has gone
        """

    def drop(self) -> None:
        """Give up the unsent data."""


class LossReports:
    """Rate limit of reports about a receiver's losses: one of each type in REPORT_PERIOD_S.

    One type reports losses while the receiver is stalled, the other that it keeps up again. Each
    loss is reported exactly once.
    """

    def __init__(self) -> None:
        self._reported = 0  # messages
        self._awaits_return = False  # a stall was reported, its end not yet
        self._quiet_until = {True: 0.0, False: 0.0}  # by type

    def is_pending(self, stalled: bool, lost: int) -> bool:
        """Return whether there is something to report, now or later.

        :param stalled: whether the receiver is stalled
        :param lost: total number of lost messages
        """
        return lost > self._reported or (self._awaits_return and not stalled)

    def take_due(self, stalled: bool, lost: int, now: float) -> Optional[int]:
        """Return the report that is due, and count it as made.

        :param stalled: whether the receiver is stalled
        :param lost: total number of lost messages
        :param now: monotonic time [s]
        :returns: messages lost since the last report; None if no report is due
        """
        if not self.is_pending(stalled, lost) or now < self._quiet_until[stalled]:
            return None
        unreported = lost - self._reported
        self._reported = lost
        self._awaits_return = stalled
        self._quiet_until[stalled] = now + REPORT_PERIOD_S
        return unreported


class SubscriberConnection:
    """Connection to one subscriber. Callers of methods that send or stall hold ``lock``.

    :param name: name of the receiver, for reports
    :param sock: connected stream socket
    :param lock: lock of all deliveries to this connection
    :param depth: most messages held, besides a partly sent delivery; the newest. None to hold the
        newest delivery only, and to wait for the receiver before
    """

    def __init__(
        self, name: str, sock: Any, lock: ContextManager[Any], depth: Optional[int] = None
    ) -> None:
        self.name = name
        self.lock = lock
        self.phase = Phase.KEEPING_UP
        #: completely sent messages, and their bytes; lost messages
        self.sent = self.sent_bytes = self.lost = 0
        self.depth = depth
        #: held deliveries; only the first may be partly sent
        self.held: Deque[Delivery] = collections.deque()
        self._held_messages = self._held_bytes = 0  # in all of them
        self._took_data_at = 0.0
        self._socket = sock
        self._probation_ends = 0.0
        self._reports = LossReports()

    @property
    def has_messages(self) -> bool:
        """Whether any message was sent, is held, or was lost."""
        return bool(self.sent or self.held or self.lost)

    def close(self) -> None:
        """Close the connection, which may be closed already."""
        self._socket.close()

    def report(self, stalled: bool, lost: int) -> None:
        """Report that a receiver is stalled and loses messages, or keeps up again.

        :param stalled: whether the receiver is stalled
        :param lost: messages lost since the last report
        """

    def report_unsent(self) -> None:
        """Report that the messages that are still held are lost, as the topic closes."""

    def takes_nothing(self, now: float) -> bool:
        """Return whether the receiver has stalled: data is held that it does not take.

        :param now: monotonic time [s]
        """
        return self.stalled and now - self._took_data_at > STALL_S

    def takes_held_data(self, now: float) -> bool:
        """Return whether data is held that a receiver of a closing topic still takes.

        :param now: monotonic time [s]
        """
        return bool(self.held) and now - self._took_data_at <= CLOSING_STALL_S

    @property
    def unsent_messages(self) -> int:
        """Number of held messages, with a partly sent one."""
        return self._held_messages

    @property
    def unsent_bytes(self) -> int:
        """Size of the held messages, with a partly sent one [bytes]."""
        return self._held_bytes

    @property
    def stalled(self) -> bool:
        """Whether the receiver is served in the background now."""
        return self.phase is Phase.STALLED

    def fileno(self) -> int:
        """Return the socket's descriptor, -1 for a closed socket."""
        return int(self._socket.fileno())

    def awaited(self) -> Tuple[int, int]:
        """Return the descriptor and the events of ``poll(2)`` to wait for before :meth:`flush`."""
        return self.fileno(), select.POLLOUT

    def send(self, data: bytes, messages: int) -> bool:
        """Send a delivery without waiting; hold the unsent rest. Nothing may be held before.

        :param data: the delivery
        :param messages: number of its messages
        :returns: whether nothing is held now, also because the receiver has gone
        """
        try:
            size = self._socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            size = 0
        except OSError:
            self.drop()
            return True
        if size != len(data):
            self._append(Delivery(data, messages, size))
            self._took_data_at = time.monotonic()
            return False
        self.sent += messages
        self.sent_bytes += size
        return True

    def hold(self, data: bytes, messages: int) -> None:
        """Hold a delivery, behind the others; drop the oldest unsent ones above the limits.

        :param data: the delivery
        :param messages: number of its messages
        """
        self.append(Delivery(data, messages))

    def append(self, delivery: Delivery) -> None:
        """Hold a delivery, as :meth:`hold` does.

        :param delivery: the delivery
        """
        self._append(delivery)
        begun = self.held[0] if self.held[0].has_begun else None
        oldest = 0 if begun is None else 1
        spared = 0 if begun is None else begun.messages
        most = (self.depth or 1) + spared
        while len(self.held) > oldest + 1 and (
            self._held_messages > most or self._held_bytes > MOST_HELD
        ):
            dropped = self._remove(oldest)
            self.lost += dropped.messages
            dropped.drop()

    def _append(self, delivery: Delivery) -> None:
        self.held.append(delivery)
        self._held_messages += delivery.messages
        self._held_bytes += delivery.size + _OVERHEAD

    def _remove(self, index: int) -> Delivery:
        delivery = self.held[index]
        del self.held[index]
        self._held_messages -= delivery.messages
        self._held_bytes -= delivery.size + _OVERHEAD
        return delivery

    def flush(self, now: float) -> bool:
        """Send held data without waiting, at most :data:`MOST_AT_ONCE` deliveries of it.

        :param now: monotonic time [s]
        :returns: whether all of it is sent; a stalled receiver then keeps up again
        """
        for _ in range(MOST_AT_ONCE):
            if not self.held:
                break
            first = self.held[0]
            try:
                first.prepare()
                size = self._socket.send(first.unsent, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return False
            except OSError:
                self.drop()
                return True
            self._took_data_at = now
            first.unsent = first.unsent[size:]
            if first.unsent:
                return False
            self.sent += first.messages
            self.sent_bytes += first.size
            self._remove(0)
        if self.held:
            return False
        if self.phase is Phase.WAITED_FOR:
            self.phase = Phase.KEEPING_UP
        elif self.phase is Phase.STALLED:
            self.phase = Phase.ON_PROBATION
            self._probation_ends = now + PROBATION_S
        return True

    def begin_wait(self, now: float) -> bool:
        """Start a wait for the receiver, unless it has stalled recently or a depth is given.

        :param now: monotonic time [s]
        :returns: whether to wait
        """
        if self.depth is not None:
            return False
        if self.phase is Phase.ON_PROBATION and now < self._probation_ends:
            return False
        self.phase = Phase.WAITED_FOR
        return True

    def stall(self) -> None:
        """Mark the receiver as stalled until all held data is sent."""
        self.phase = Phase.STALLED

    def drop(self) -> None:
        """Close the connection: the receiver has gone, or the socket is closed."""
        self.phase = Phase.GONE
        for delivery in self.held:
            delivery.drop()
        self.held.clear()
        self._held_messages = self._held_bytes = 0
        self.close()

    def report_if_due(self, now: float) -> None:
        """Report a stall, losses or the return. Without ``lock``: a report may take other locks.

        :param now: monotonic time [s]
        """
        if self.phase is not Phase.GONE:
            stalled = self.stalled
            lost = self._reports.take_due(stalled, self.lost, now)
            if lost is not None:
                self.report(stalled, lost)

    def needs_attention(self) -> bool:
        """Return whether the receiver is stalled, or a report about it is pending."""
        if self.phase is Phase.GONE:
            return False
        return self.stalled or self._reports.is_pending(self.stalled, self.lost)
