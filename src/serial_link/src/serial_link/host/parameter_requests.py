"""Parameter requests of a board: which one it still waits for."""

import math

#: rosserial's library waits 1 s for an answer by default, part of which is time on the line [s].
ANSWER_WITHIN_S = 0.8
#: This process was paused if it has not polled for this long [s].
PAUSE_S = 0.75


class ParameterRequests:
    """Record of a board's requests, of which only the last one may be answered.

    The library waits for one answer at a time, and the protocol does not number them. A late answer
    is taken for that of the next request, whose own answer is then taken for that of the one after
    it, and so on. So a request is not answered if it may have timed out on the board, nor is the
    first one after a pause of this process: the board waits until its timeout, in which a late
    answer arrives. Time is an argument [s].
    """

    def __init__(self) -> None:
        self._count = 0
        self._received_at = self._resumed_at = -math.inf
        self._polled_at = math.inf
        self._is_suspect = False

    def poll(self, now: float) -> None:
        """Detect a pause; call this often, and before :meth:`add`.

        :param now: the time [s]
        """
        if now - self._polled_at > PAUSE_S:
            self._resumed_at = now
        self._polled_at = now

    def add(self, now: float) -> int:
        """Record a request.

        :param now: the time [s]
        :returns: its number
        """
        self._count += 1
        self._received_at = now
        self._is_suspect = now - self._resumed_at < PAUSE_S
        self._resumed_at = -math.inf
        return self._count

    def is_pending(self, now: float, number: int) -> bool:
        """Return whether the board waits for the answer to a request, and for no other.

        :param now: the time [s]
        :param number: of the request
        """
        is_last = number == self._count and not self._is_suspect
        return is_last and now - self._received_at < ANSWER_WITHIN_S
