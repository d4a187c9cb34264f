"""Log of a link, throttled per key; a new connection resets the limits."""

from typing import Callable

from nodekit import Throttle


class ThrottledLog:
    """Log that is throttled per text or key.

    :param period: shortest time between two lines with the same key [s]
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._throttle = Throttle(period)

    def log(self, log: Callable[[str], None], text: str, key: str = "") -> None:
        """Log a text, unless its key was logged within the period.

        :param log: log function
        :param text: the text
        :param key: of the limit; the text by default
        """
        if self._throttle.is_due(key or text):
            log(text)

    def reset(self) -> None:
        """Reset all limits."""
        self._throttle = Throttle(self._period)
