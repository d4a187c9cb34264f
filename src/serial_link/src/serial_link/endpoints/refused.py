"""A topic or a service of a board that there cannot be in ROS."""

from serial_link.host.counts import REFUSED, Counts
from serial_link.negotiation.topic_book import Endpoint


class RefusedEndpoint:
    """Takes the place of what was refused: its messages are counted, and nothing else.

    :param tally: counts them
    """

    def __init__(self, tally: Counts) -> None:
        self._tally = tally

    def adopt(self, endpoint: Endpoint) -> None:
        """Have another id: of no matter."""

    def receive(self, payload: bytes) -> None:
        """Count a message."""
        self._tally.add(REFUSED)

    def enter(self) -> None:
        """Begin with a board that was started anew: nothing is to be done."""

    def fail(self, why: str) -> None:
        """Do without an answer: there is none."""
