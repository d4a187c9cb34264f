"""Null object for a topic or service of a board that cannot be opened in ROS."""

from typing import Optional

from serial_link.host.counters import REFUSED, Counters
from serial_link.link.board_link import BoardLink
from serial_link.negotiation.topic_table import Endpoint


class NullEndpoint:
    """Null object for a rejected topic or service: counts its messages, and ends a board's calls.

    :param counters: where they are counted
    :param caller: link to the board, if it calls the service and waits for a response
    """

    def __init__(self, counters: Counters, caller: Optional[BoardLink] = None) -> None:
        self._counters, self._caller = counters, caller

    def update(self, endpoint: Endpoint) -> None:
        """ID changed: nothing to do."""

    def receive(self, payload: bytes) -> None:
        """Count a message; end the wait for a response."""
        self._counters.add(REFUSED)
        if self._caller is not None:
            self._caller.request_topics()

    def on_sync(self) -> None:
        """Board synchronized: nothing to do."""

    def on_lost(self, why: str) -> None:
        """Board lost: nothing to do."""
