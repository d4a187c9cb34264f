"""Age of a robot's messages."""

import math


class Staleness:
    """Age of the last message of a stream.

    It is the larger of the times since its stamp and since its arrival. The stamp alone would trust
    a clock that is ahead; the arrival alone would take messages that a broken connection delivers
    late for new ones.
    """

    def __init__(self) -> None:
        self._stamp = self._arrived_at = math.nan

    def record_message(self, stamp: float, now: float) -> None:
        """Record a message.

        :param stamp: its stamp [s]; 0 if it has none
        :param now: its arrival, by the same clock [s]
        """
        self._stamp, self._arrived_at = stamp or now, now

    def skew(self, now: float, limit: float) -> float:
        """Return how far the stamps of timely messages are behind the clock [s].

        :param now: time, by the same clock [s]
        :param limit: age up to which a message is timely [s]
        :returns: 0 if the stamps are timely too, or no messages arrive
        """
        behind = self._arrived_at - self._stamp
        return behind if 0.0 <= now - self._arrived_at <= limit < behind else 0.0

    def age(self, now: float) -> float:
        """Return the age of the last message [s]; infinite without one, or after a clock reset.

        :param now: time, by the same clock [s]
        """
        since = now - self._arrived_at
        return max(since, now - self._stamp) if since >= 0.0 else math.inf
