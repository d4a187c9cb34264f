"""HTTP server of the pages, in a separate thread; it starts before the master answers."""

import asyncio
import socket
import threading
from typing import Any, AsyncIterator, Callable, Dict, List, Optional, Sequence

import rosgraph
import rospy
import tornado.ioloop

from nodekit.master import MasterClient, MasterUnreachable
from topic_scope.analysis.csv_rows import header
from topic_scope.page.open_page import Page
from topic_scope.protocol.image_request import ImageRequest
from topic_scope.protocol.options import Options
from topic_scope.web import handlers
from topic_scope.web.image_feed import ImageReply
from topic_scope.web.scope_session import ScopeSession


def master_message(text: str) -> Dict[str, Any]:
    """Return the message about the state of the master.

    :param text: the problem; empty if the master answers
    """
    return {"type": "master", "text": text}


class PlaceholderScope:
    """Placeholder until the scope session exists.

    :param uri: URI of the master
    :param window: initial time span of a page [s]
    """

    def __init__(self, uri: str, window: float) -> None:
        self.sockets: List[handlers.PageSocket] = []
        self._uri, self._window = uri, window
        self._trouble = ""

    def open(self, connection: handlers.PageSocket) -> Page:
        """Send a page the reason for the wait, if it is known."""
        self.sockets.append(connection)
        connection.send([master_message(self._trouble)])
        return Page(self._window)

    def miss(self) -> None:
        """Report to all pages that the master does not answer."""
        self._trouble = f"There is no ROS master at {self._uri} yet: the scope waits for it."
        for connection in self.sockets:
            connection.send([master_message(self._trouble)])

    def close(self, connection: handlers.PageSocket) -> None:
        """Remove a page."""
        if connection in self.sockets:
            self.sockets.remove(connection)

    def handle(self, page: Page, _text: Any) -> None:
        """Ignore a request: a page repeats its requests to the scope session."""

    async def image(self, _request: ImageRequest) -> ImageReply:
        """Return the reason why there is no image."""
        return ImageReply({"problem": "the scope waits for the ROS master"})

    async def export(self, names: Sequence[str], start: float, end: float) -> AsyncIterator[str]:
        """Return only the header row: there are no samples."""
        yield header("time", "received", *names)


class HttpServer:
    """HTTP server of the pages; they wait until there is a scope session.

    :param options: the command line, with the port in use
    :param sockets: listening sockets
    """

    def __init__(self, options: Options, sockets: List[socket.socket]) -> None:
        self._options, self._sockets = options, sockets
        self._waiting = PlaceholderScope(rosgraph.get_master_uri(), options.window)
        self._holder = handlers.ScopeHolder(self._waiting)
        self._running = threading.Event()
        self._error: Optional[Exception] = None
        threading.Thread(target=self._serve, name="web", daemon=True).start()
        self._running.wait()
        if self._error is not None:
            raise self._error
        threading.Thread(target=self._look_for_master, daemon=True).start()

    def show(self, make: Callable[[], ScopeSession]) -> None:
        """Replace the placeholder by a scope session.

        :param make: creates it, in the web thread
        :raises Exception: as raised by ``make``
        """
        made = threading.Event()

        def begin() -> None:
            try:
                self._holder.scope = make()
                while self._waiting.sockets:
                    self._waiting.sockets.pop(0).enter()
            except Exception as error:
                self._error = error
            made.set()

        self._loop.add_callback(begin)
        made.wait()
        if self._error is not None:
            raise self._error

    def _serve(self) -> None:
        try:
            asyncio.set_event_loop(asyncio.new_event_loop())
            self._loop = tornado.ioloop.IOLoop.current()
            handlers.serve(self._options, self._sockets, self._holder)
        except Exception as error:
            self._error = error
            self._running.set()
            return
        self._loop.add_callback(self._running.set)
        self._loop.start()

    def _look_for_master(self) -> None:
        """Log the page's address and report a missing master, if the master does not answer."""
        try:
            with MasterClient("/scope", timeout=1.0) as master:
                master.read([])
        except MasterUnreachable:
            rospy.logwarn("the scope is already at %s", self._options.url)
            self._loop.add_callback(self._waiting.miss)
