"""Log of a link with one limit per sentence, which a new connection resets."""

from typing import Callable

from nodekit import Throttle


class ThrottledLog:
    """Log with one limit per sentence or key.

    :param period: shortest time between two lines of one key [s]
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._throttle = Throttle(period)

    def log(self, log: Callable[[str], None], text: str, key: str = "") -> None:
        """Log a text, unless its key was logged within the period.

        :param log: logs it
        :param text: the sentence
        :param key: what it is about; the sentence itself by default
        """
        if self._throttle.is_due(key or text):
            log(text)

    def reset(self) -> None:
        """Reset all limits."""
        self._throttle = Throttle(self._period)
