"""Synchronization with a board: the table of :mod:`.sync_states`, and its deadlines."""

import math
from typing import List

from serial_link.host.sync_states import (
    ASK,
    NEGOTIATING,
    CLOSED,
    DUE,
    MESSAGE,
    SYNCED,
    OPENED,
    OVERDUE,
    PROBE,
    RESTART,
    SILENT,
    TIME,
    TOPIC,
    UNKNOWN,
    move,
)

#: A board that has not proven for this long that it is configured is silent [s].
QUIET_S = 0.3
#: How often a board is asked that does not answer, and probed while it is silent [s].
ASK_EVERY_S, PROBE_EVERY_S = 0.25, 0.25
#: A configured board asks for the time every 2.5 s, or once a loop if that takes longer. It forgets
#: a host that has not answered for this long [s].
OVERDUE_S = 11.0
#: Events that prove that the board is configured. The time proves it only in other states than
#: SYNCED: a board that was reset asks for it whenever a message to it has a byte 0xff.
_PROOFS = (OPENED, TOPIC, MESSAGE, UNKNOWN)


class SyncMonitor:
    """Monitor of the synchronization with a board. Time is an argument [s].

    :ivar state: of the table
    :ivar restarts: number of restarts of the board
    """

    def __init__(self) -> None:
        self.state = CLOSED
        self.restarts = 0
        self._proven_at = self._asked_at = self._probed_at = -math.inf

    def handle(self, now: float, event: str) -> List[str]:
        """Follow an event.

        :param now: the time [s]
        :param event: of the table
        :returns: actions of the table, in order
        """
        was = self.state
        if event in _PROOFS or (event == TIME and was != SYNCED):
            self._proven_at = now
        self.state, action = move(was, event)
        if event == UNKNOWN and now - self._asked_at < ASK_EVERY_S:
            action = ""  # what it tells when it is asked is under way
        if event == OPENED:
            self._asked_at = now
        actions = [action] if action else []
        if action == RESTART:
            self.restarts += was not in (CLOSED, NEGOTIATING) and self.state == NEGOTIATING
            if self.state == NEGOTIATING:
                actions.append(ASK)
        if ASK in actions:
            self._asked_at = now
        if PROBE in actions:
            self._probed_at = now
        return actions

    def poll(self, now: float) -> List[str]:
        """Do what is due.

        :param now: the time [s]
        :returns: actions of the table, in order
        """
        if now < self.next_due():
            return []
        is_overdue = self.state == SILENT and now - self._proven_at >= OVERDUE_S
        return self.handle(now, OVERDUE if is_overdue else DUE)

    def next_due(self) -> float:
        """Return when :meth:`poll` has something to do [s]."""
        if self.state == CLOSED:
            return math.inf
        if self.state == NEGOTIATING:
            return self._asked_at + ASK_EVERY_S
        if self.state == SYNCED:
            return self._proven_at + QUIET_S
        return self._probed_at + PROBE_EVERY_S
