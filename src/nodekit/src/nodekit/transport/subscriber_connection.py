"""The way to one receiver over a stream socket: what it takes, what is held back, how it fares.

Memory for a receiver that does not read is two deliveries at most: one that is partly on the wire,
the rest of which goes out before anything else (a message is never torn), and the newest one, so
that the last value of a slow stream arrives. Those in between are lost, counted and reported.
"""

import enum
import socket
from typing import Any, ContextManager, List, Optional

#: a receiver that has stalled is not waited for again until so long after its return, s
PROBATION_S = 10.0
#: shortest time between two reports of the same kind about the same receiver, s
REPORT_PERIOD_S = 10.0


class Phase(enum.Enum):
    """How a receiver fares. From each phase it may be gone, which is the last.

    ============  ==============================================  ============
    phase         event                                           next phase
    ============  ==============================================  ============
    KEEPING_UP    its socket is full                              WAITED_FOR
    WAITED_FOR    it takes all that is held back                  KEEPING_UP
    WAITED_FOR    the wait is over                                STALLED
    STALLED       it takes all that is held back                  ON_PROBATION
    ON_PROBATION  its socket is full within PROBATION_S           STALLED
    ON_PROBATION  its socket is full later                        WAITED_FOR
    ============  ==============================================  ============
    """

    #: takes each delivery at once
    KEEPING_UP = enum.auto()
    #: is given time to read; its delivery may be partly on the wire
    WAITED_FOR = enum.auto()
    #: gets the newest delivery only, in the background
    STALLED = enum.auto()
    #: takes each delivery at once again, but has stalled before
    ON_PROBATION = enum.auto()
    #: the other end is closed
    GONE = enum.auto()


class Delivery:
    """Messages that go out together, and what of them is not yet on the wire.

    :param data: the messages, one after the other
    :param messages: how many there are
    :param sent: how much of the data is on the wire, bytes
    """

    __slots__ = ("messages", "size", "unsent")

    def __init__(self, data: bytes, messages: int, sent: int = 0) -> None:
        self.messages = messages
        self.size = len(data)
        self.unsent = memoryview(data)[sent:]

    @property
    def has_begun(self) -> bool:
        """Whether some of it is on the wire, so that the rest has to follow."""
        return len(self.unsent) < self.size


class LossReports:
    """Decides when to tell of a receiver's losses: each kind of report once in REPORT_PERIOD_S.

    One kind tells of losses while the receiver is stalled, the other that it keeps up again. No
    loss is told of twice, and none is left out.
    """

    def __init__(self) -> None:
        self._told = 0  # messages
        self._awaits_return = False  # a stall was told of, its end not yet
        self._quiet_until = {True: 0.0, False: 0.0}  # by kind

    def is_pending(self, stalled: bool, lost: int) -> bool:
        """Tell whether there is something to report, be it now or later.

        :param stalled: whether the receiver is stalled
        :param lost: how many messages it has lost in all
        :returns: whether there is
        """
        return lost > self._told or (self._awaits_return and not stalled)

    def take_due(self, stalled: bool, lost: int, now: float) -> Optional[int]:
        """Take the report that is due, if one is.

        :param stalled: whether the receiver is stalled
        :param lost: how many messages it has lost in all
        :param now: monotonic time, s
        :returns: messages lost since the last report; None if none is due
        """
        if not self.is_pending(stalled, lost) or now < self._quiet_until[stalled]:
            return None
        news = lost - self._told
        self._told = lost
        self._awaits_return = stalled
        self._quiet_until[stalled] = now + REPORT_PERIOD_S
        return news


class SubscriberConnection:
    """The way to one receiver. Whoever calls a method that sends or stalls holds ``lock``.

    :param name: the receiver's name, for reports
    :param sock: connected stream socket
    :param lock: lock of everything that delivers to this link
    """

    def __init__(self, name: str, sock: Any, lock: ContextManager[Any]) -> None:
        self.name = name
        self.lock = lock
        self.phase = Phase.KEEPING_UP
        #: messages, and their bytes, that have gone out as a whole; messages that were lost
        self.sent = self.sent_bytes = self.lost = 0
        #: what is held back, two at most, only the first of them begun; a new delivery goes behind
        self.held: List[Delivery] = []
        self._socket = sock
        self._probation_ends = 0.0
        self._reports = LossReports()

    def close(self) -> None:
        """Close the connection, which may be closed already."""
        self._socket.close()

    def report(self, stalled: bool, lost: int) -> None:
        """Tell of a stalled receiver that loses messages, or of one that keeps up again.

        :param stalled: which of the two
        :param lost: messages lost since the last report
        """

    @property
    def stalled(self) -> bool:
        """Whether the receiver is being left behind now."""
        return self.phase is Phase.STALLED

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
            size = 0
        except OSError:
            self.drop()
            return True
        if size != len(data):
            self.held.append(Delivery(data, messages, size))
            return False
        self.sent += messages
        self.sent_bytes += size
        return True

    def hold(self, data: bytes, messages: int) -> None:
        """Hold a delivery back behind one that has begun, in place of one that has not.

        :param data: the delivery
        :param messages: how many messages it holds
        """
        if self.held and not self.held[-1].has_begun:
            self.lost += self.held.pop().messages
        self.held.append(Delivery(data, messages))

    def flush(self, now: float) -> bool:
        """Send what is held back, as far as the socket takes it at once.

        :param now: monotonic time, s
        :returns: whether nothing is held back any more; a stalled receiver is back then
        """
        while self.held:
            first = self.held[0]
            try:
                size = self._socket.send(first.unsent, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return False
            except OSError:
                self.drop()
                return True
            first.unsent = first.unsent[size:]
            if first.unsent:
                return False
            self.sent += first.messages
            self.sent_bytes += first.size
            del self.held[0]
        if self.phase is Phase.WAITED_FOR:
            self.phase = Phase.KEEPING_UP
        elif self.phase is Phase.STALLED:
            self.phase = Phase.ON_PROBATION
            self._probation_ends = now + PROBATION_S
        return True

    def begin_wait(self, now: float) -> bool:
        """Give the receiver time to read, unless it has stalled lately.

        :param now: monotonic time, s
        :returns: whether to wait for it
        """
        if self.phase is Phase.ON_PROBATION and now < self._probation_ends:
            return False
        self.phase = Phase.WAITED_FOR
        return True

    def stall(self) -> None:
        """Leave the receiver behind until it has taken all that is held back."""
        self.phase = Phase.STALLED

    def drop(self) -> None:
        """Give the receiver up, as the other end is gone or the socket is closed."""
        self.phase = Phase.GONE
        self.held.clear()
        self.close()

    def report_if_due(self, now: float) -> None:
        """Report a stall, losses or the return. Without ``lock``: a report may take other locks.

        :param now: monotonic time, s
        """
        if self.phase is not Phase.GONE:
            stalled = self.stalled
            lost = self._reports.take_due(stalled, self.lost, now)
            if lost is not None:
                self.report(stalled, lost)

    def needs_attention(self) -> bool:
        """Tell whether the receiver is stalled, or a report about it pending."""
        if self.phase is Phase.GONE:
            return False
        return self.stalled or self._reports.is_pending(self.stalled, self.lost)
