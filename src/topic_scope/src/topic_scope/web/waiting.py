"""What pages are told as long as there is no scope yet, as the master is missing."""

from typing import Any, AsyncIterator, Dict, List, Sequence

from topic_scope.analysis.csv_rows import header
from topic_scope.page.page import Page
from topic_scope.protocol import protocol
from topic_scope.web.web import Socket


def master_message(text: str) -> Dict[str, Any]:
    """Return the message that tells a page of the master.

    :param text: what is wrong, in words; empty where it answers
    """
    return {"type": "master", "text": text}


class Waiting:
    """Stands where the server will be.

    :param uri: where the master is to be
    :param window: span of time that a page sees at first, s
    """

    def __init__(self, uri: str, window: float) -> None:
        self.sockets: List[Socket] = []
        self._uri, self._window = uri, window
        self._trouble = ""

    def open(self, connection: Socket) -> Page:
        """Tell a page what it waits for, as far as that is known."""
        self.sockets.append(connection)
        connection.send([master_message(self._trouble)])
        return Page(self._window)

    def miss(self) -> None:
        """Tell pages that the master does not answer: before, the scope may only need a moment."""
        self._trouble = f"There is no ROS master at {self._uri} yet: the scope waits for it."
        for connection in self.sockets:
            connection.send([master_message(self._trouble)])

    def close(self, connection: Socket) -> None:
        """Forget a page."""
        if connection in self.sockets:
            self.sockets.remove(connection)

    def handle(self, page: Page, request: protocol.Request) -> None:
        """Leave a request: what a page wants it says again to the server."""

    async def export(self, names: Sequence[str], start: float, end: float) -> AsyncIterator[str]:
        """Return the file's first row alone: there are no samples."""
        yield header("time", "received", *names)
