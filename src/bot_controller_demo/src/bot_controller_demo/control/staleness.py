"""Age of a robot's messages."""

import math


class Staleness:
    """Age of the last message of a stream.

    It is the larger one of the times since its stamp and since its arrival. The stamp alone would
    take the word of a clock that is ahead; the arrival alone would take what a cut link delivers
    late, all at once, for new.
    """

    def __init__(self) -> None:
        self._stamp = self._arrived_at = math.nan

    def record_message(self, stamp: float, now: float) -> None:
        """Record a message.

        :param stamp: when it was made, s; 0 if it has no stamp
        :param now: when it has arrived, s by the same clock
        """
        self._stamp, self._arrived_at = stamp or now, now

    def skew(self, now: float, limit: float) -> float:
        """Return how far stamps are behind the clock, of messages that arrive in time [s].

        :param now: s, by the same clock
        :param limit: age up to which a message has arrived in time, s
        :returns: 0 if the stamps are in time too, or no messages arrive
        """
        behind = self._arrived_at - self._stamp
        return behind if 0.0 <= now - self._arrived_at <= limit < behind else 0.0

    def age(self, now: float) -> float:
        """Return the age of the last message [s]; infinite without one, or after a clock reset.

        :param now: s, by the same clock
        """
        since = now - self._arrived_at
        return max(since, now - self._stamp) if since >= 0.0 else math.inf
