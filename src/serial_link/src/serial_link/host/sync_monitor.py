"""Detection of silent and restarted boards: state machine of :mod:`.sync_states`, with timeouts."""

import math
from typing import List

from serial_link.host.sync_states import (
    ASK,
    ASKED,
    CLOSED,
    DAMAGED,
    DUE,
    EMPTY,
    HEARD,
    MESSAGE,
    OPENED,
    OVERDUE,
    PROBE,
    PROBING,
    RESTART,
    SEEKING,
    SILENT,
    SYNCED,
    TIME,
    TOPIC,
    UNKNOWN,
    find_transition,
)

#: After this time without proof that it is configured, a quick board counts as silent [s]; a board
#: that has not answered a topic request for this long is probed.
QUIET_S = 0.3
#: Pause between two probes [s], and its growth factor.
PROBE_EVERY_S, GROWTH = 0.25, 1.5
#: Pause between two topic requests while frames are unknown or damaged [s]; it doubles.
ASK_EVERY_S = 0.25
#: The topics follow within this time after a time request that answers the topic request [s].
FOLLOWS_S = 0.1
#: Interval at which a configured board requests the time, or once per loop iteration if that takes
#: longer [s]; excess that indicates a slow loop [s]; time without an answer after which the board
#: forgets its host [s].
TIME_EVERY_S, LATE_S, OVERDUE_S = 2.5, 0.2, 11.0
#: A slow board counts as silent after this many iterations of its loop without a frame.
SILENT_ITERATIONS = 1.5
#: After this many topic requests answered only by a time request, the sketch has no topics.
EMPTY_ANSWERS = 2
#: Events that prove that the board is configured. TIME does not: a board that was reset requests
#: the time whenever it receives a byte 0xff.
_PROOFS = (OPENED, TOPIC, MESSAGE, UNKNOWN)


class SyncMonitor:
    """Monitor of the synchronization with a board. Time is an argument [s].

    The monitor learns how long the board may be silent: from the board's answer times, and from how
    late the board requests the time.

    :param frame_s: time on the line of a frame that announces a topic [s]

    :ivar state: of the table
    :ivar restarts: number of restarts of the board
    """

    def __init__(self, frame_s: float = 0.0) -> None:
        self.state = CLOSED
        self.restarts = 0
        self._frame_s = frame_s
        #: Duration of a loop iteration of the sketch [s]; 0 for a quick loop. The second value
        #: excludes the last time request, which may have answered a probe.
        self._loop_s = self._loop_before_s = 0.0
        #: Longest time between two frames since the last time request [s].
        self._gap_s = 0.0
        self._pause_s = self._ask_pause_s = 0.0
        self._empty_answers = 0
        self._proven_at = self._alive_at = self._asked_at = self._probed_at = -math.inf
        #: Time of the last time request since the topic request.
        self._time_at = -math.inf
        self._is_answered = True

    @property
    def patience(self) -> float:
        """Longest time the board may take to answer [s]."""
        return max(QUIET_S, SILENT_ITERATIONS * self._loop_s) + self._frame_s

    @property
    def is_bare(self) -> bool:
        """Whether the topic request was answered, as far as received, without topics."""
        return self.state in (ASKED, SEEKING) and self._time_at >= self._asked_at

    def handle(self, now: float, event: str) -> List[str]:
        """Handle an event.

        :param now: the time [s]
        :param event: of the table
        :returns: actions of the table, in order
        """
        was = self.state
        if event == MESSAGE and was == SYNCED:  # as below: shortcut for most events
            self._gap_s = max(self._gap_s, now - self._alive_at)
            self._proven_at = self._alive_at = now
            return []
        if event == OPENED:
            self._loop_s = self._loop_before_s = 0.0
        elif event == TIME:
            self._learn_loop_time(now)
        elif event == TOPIC:
            self._receive_answer(now)
        if event in _PROOFS:
            self._proven_at = now
        if event in _PROOFS or event == TIME:
            self._gap_s = 0.0 if event == TIME else max(self._gap_s, now - self._alive_at)
            self._alive_at = now
        is_asked = event in (UNKNOWN, DAMAGED) and find_transition(was, event).action == ASK
        is_pending = was == SEEKING and event == UNKNOWN and not self.is_bare
        if is_asked and (is_pending or not self._may_ask(now)):
            event = MESSAGE if event == UNKNOWN else ""  # its answer is in transit
        self.state, action = find_transition(was, event)
        actions = [action] if action else []
        if action == RESTART:
            self.restarts += was == PROBING and event == TIME
            self._ask_pause_s, self._loop_s = 0.0, self._loop_before_s
            if self.state == ASKED:
                actions.append(ASK)
        if ASK in actions:
            self._record_question(now)
        if PROBE in actions:
            self._probed_at = now
            is_first = was not in (self.state, PROBING)
            longer = max(GROWTH * self._pause_s, SILENT_ITERATIONS * self._loop_s)
            self._pause_s = PROBE_EVERY_S + self._frame_s if is_first else longer
        return actions

    def ask(self, now: float) -> List[str]:
        """Return the action that requests the topics again, because some are missing.

        :param now: the time [s]
        """
        self._record_question(now)
        return [ASK]

    def poll(self, now: float) -> List[str]:
        """Handle elapsed timeouts.

        :param now: the time [s]
        :returns: actions of the table, in order
        """
        if now < self.next_due():
            return []
        event = DUE
        if self.state == SEEKING and now >= self._asked_at + OVERDUE_S:
            event = OVERDUE
        elif self.state == SILENT and now >= self._alive_at + OVERDUE_S:
            event = OVERDUE
        elif self.state == ASKED and self.is_bare:
            self._empty_answers += 1
            event = EMPTY if self._empty_answers >= EMPTY_ANSWERS else DUE
        return self.handle(now, event)

    def next_due(self) -> float:
        """Return when :meth:`poll` next has work [s]."""
        if self.state == CLOSED:
            return math.inf
        if self.state == ASKED:
            return self._asked_at + self.patience
        if self.state == HEARD:
            return self._alive_at + FOLLOWS_S + self._frame_s
        if self.state == SYNCED:
            return self._proven_at + self.patience
        if self.state == PROBING:
            return self._probed_at + PROBE_EVERY_S + self._frame_s
        since = self._asked_at if self.state == SEEKING else self._alive_at
        return min(self._probed_at + self._pause_s, since + OVERDUE_S)

    def _record_question(self, now: float) -> None:
        self._asked_at, self._time_at, self._is_answered = now, -math.inf, False

    def _receive_answer(self, now: float) -> None:
        """Learn the board's response time from its answer to a topic request."""
        self._empty_answers = 0
        if not self._is_answered:
            self._is_answered = True
            if now - self._asked_at > QUIET_S + self._frame_s:
                self._loop_s = max(self._loop_s, now - self._asked_at)

    def _learn_loop_time(self, now: float) -> None:
        """Learn the duration of a loop iteration from a time request.

        The period is a whole number of iterations. None takes longer than the longest gap between
        two frames.
        """
        period, self._time_at = now - self._time_at, now
        if self.state != PROBING:
            self._loop_before_s = self._loop_s
        if self.state in (SYNCED, SILENT, PROBING) and period < math.inf:
            if period > TIME_EVERY_S + LATE_S + self._frame_s:
                self._loop_s = min(period, max(self._gap_s, now - self._alive_at))
            elif period > TIME_EVERY_S - LATE_S:
                self._loop_s = 0.0

    def _may_ask(self, now: float) -> bool:
        """Return whether another topic request may be sent; if so, lengthen the next pause."""
        since = now - self._asked_at
        if since > 2.0 * self._ask_pause_s:
            self._ask_pause_s = ASK_EVERY_S
        if since < max(self._ask_pause_s, self.patience):
            return False
        self._ask_pause_s = min(2.0 * self._ask_pause_s, OVERDUE_S)
        return True
