"""Null object for a topic or service of a board that cannot be opened in ROS."""

from serial_link.host.counters import REFUSED, Counters
from serial_link.negotiation.topic_table import Endpoint


class NullEndpoint:
    """Null object for a rejected topic or service: counts its messages.

    :param counters: where they are counted
    """

    def __init__(self, counters: Counters) -> None:
        self._counters = counters

    def update(self, endpoint: Endpoint) -> None:
        """ID changed: nothing to do."""

    def receive(self, payload: bytes) -> None:
        """Count a message."""
        self._counters.add(REFUSED)

    def on_sync(self) -> None:
        """Board synchronized: nothing to do."""

    def on_lost(self, why: str) -> None:
        """Board lost: nothing to do."""
