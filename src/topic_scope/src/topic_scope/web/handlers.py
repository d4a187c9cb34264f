"""Request handlers of the web server: files, data as CSV, and the WebSocket."""

import asyncio
import errno
import json
import os
import socket
import webbrowser
from typing import Any, Dict, List, Optional

import rospkg
import tornado.httpserver
import tornado.iostream
import tornado.netutil
import tornado.web
import tornado.websocket

from topic_scope.page.state import Page
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.export_request import export_of
from topic_scope.protocol.options import Options
from topic_scope.protocol.requests import LONGEST
from topic_scope.web import access

#: Where Debian installs dygraphs.
DYGRAPHS = "/usr/share/javascript/dygraphs"
#: Most pages at a time.
PAGES = 32
#: Why a connection is ended where there are as many: try again later.
TRY_AGAIN = 1013
#: What the system keeps for a page that does not read [bytes]; it would let it grow to megabytes.
_SEND_BUFFER = 256 * 1024


class ScopeHolder:
    """Holder of the scope that pages show, which is replaced once the master answers.

    :ivar scope: has ``sockets``, ``open``, ``close``, ``handle`` and ``export``
    """

    def __init__(self, scope: Any) -> None:
        self.scope = scope


def bind(options: Options) -> List[socket.socket]:
    """Return the sockets to serve at.

    :raises OSError: if the address is not one of this machine's, or the ports are taken
    """
    *others, last = options.ports
    for port in others:
        try:
            return tornado.netutil.bind_sockets(port, options.address)
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise
    return tornado.netutil.bind_sockets(last, options.address)


def _check_host(handler: tornado.web.RequestHandler) -> None:
    if not access.is_known_name(
        handler.request.host, handler.application.settings["machine_names"]
    ):
        raise tornado.web.HTTPError(403, "not a name of this machine")


def set_strict_headers(handler: tornado.web.RequestHandler) -> None:
    """Set headers that keep a page from loading other sites' content, and from being framed."""
    handler.set_header("X-Content-Type-Options", "nosniff")
    handler.set_header("Cache-Control", "no-cache")
    handler.set_header(
        "Content-Security-Policy",
        f"default-src 'self'; connect-src 'self' ws://{_plain(handler.request.host)}; "
        "img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; frame-ancestors "
        "'none'",
    )


def _plain(host: str) -> str:
    return "".join(letter for letter in host if letter.isalnum() or letter in ".:-[]")


class StaticFiles(tornado.web.StaticFileHandler):
    """Handler for the files of one folder; paths outside of it are rejected."""

    def prepare(self) -> None:
        _check_host(self)

    def set_default_headers(self) -> None:
        set_strict_headers(self)


class CsvData(tornado.web.RequestHandler):
    """Handler for samples as CSV.

    :param holder: has what has them
    """

    def initialize(self, holder: ScopeHolder) -> None:
        self._scope = holder.scope

    def prepare(self) -> None:
        _check_host(self)

    def set_default_headers(self) -> None:
        set_strict_headers(self)

    async def get(self) -> None:
        """Send all samples of some fields in a time span."""
        query: Dict[str, Any] = {
            name: self.get_argument(name) for name in ("start", "end") if self.get_arguments(name)
        }
        try:
            wanted = export_of({"fields": self.get_arguments("field"), **query})
        except RequestError as error:
            raise tornado.web.HTTPError(400, str(error)) from None
        self.set_header("Content-Type", "text/csv; charset=utf-8")
        self.set_header("Content-Disposition", 'attachment; filename="scope.csv"')
        try:
            async for text in self._scope.export(*wanted):
                self.write(text)
                await self.flush()
        except tornado.iostream.StreamClosedError:
            pass  # the page does not want the rest


class PageSocket(tornado.websocket.WebSocketHandler):
    """WebSocket of one page.

    :param holder: has what the page is about
    """

    def initialize(self, holder: ScopeHolder) -> None:
        self._holder = holder
        self._writing: Optional["asyncio.Future[None]"] = None
        self.page: Optional[Page] = None

    def prepare(self) -> None:
        _check_host(self)

    def check_origin(self, origin: str) -> bool:
        return access.is_same_origin(origin, self.request.host)

    def open(self, *_arguments: str, **_named: str) -> None:
        stream = self.ws_connection.stream if self.ws_connection else None
        if stream is not None and stream.socket is not None:
            stream.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        self.set_nodelay(True)
        if len(self._holder.scope.sockets) >= PAGES:  # a browser shows no other answer than this
            self.close(TRY_AGAIN, f"{PAGES} pages of this scope are open already: close one")
            return
        self.enter()

    def enter(self) -> None:
        """Attach the page to the present scope."""
        self.page = self._holder.scope.open(self)

    def on_message(self, message: Any) -> None:
        if self.page is not None:
            self._holder.scope.handle(self.page, message)

    def on_close(self) -> None:
        self._holder.scope.close(self)

    @property
    def is_ready(self) -> bool:
        """Whether all earlier messages have been written to the socket."""
        return self._writing is None or self._writing.done()

    def send(self, messages: List[Dict[str, Any]]) -> None:
        """Send messages; only when ready."""
        for message in messages:
            try:
                text = json.dumps(message, allow_nan=False, separators=(",", ":"))
                self._writing = self.write_message(text)
            except tornado.websocket.WebSocketClosedError:
                return
            self._writing.add_done_callback(lambda future: future.exception())


def application(holder: ScopeHolder, folder: str, names: List[str]) -> tornado.web.Application:
    """Return the web application.

    :param holder: has what pages are about
    :param folder: where the page's files are
    :param names: what this machine is called
    """
    return tornado.web.Application(
        [
            (r"/ws", PageSocket, {"holder": holder}),
            (r"/data\.csv", CsvData, {"holder": holder}),
            (r"/static/(.*)", StaticFiles, {"path": folder}),
            (r"/dygraphs/(.*)", StaticFiles, {"path": DYGRAPHS}),
            (r"/()", StaticFiles, {"path": folder, "default_filename": "index.html"}),
        ],
        machine_names=names,
        websocket_max_message_size=LONGEST,
        websocket_ping_interval=20,
        log_function=lambda handler: None,
    )


def serve(options: Options, sockets: List[socket.socket], holder: ScopeHolder) -> None:
    """Serve pages from now on, in the loop of the thread that calls this.

    :param options: the command line
    :param sockets: where to serve
    :param holder: what pages show
    """
    # roslib asks the program rospack, which a Ctrl-C at that moment ends as well.
    folder = os.path.join(rospkg.RosPack().get_path("topic_scope"), "www")
    names = access.names_of(socket.gethostname(), socket.getfqdn(), options.address)
    server = tornado.httpserver.HTTPServer(
        application(holder, folder, names), max_header_size=16384, max_body_size=4096
    )
    server.add_sockets(sockets)


def open_browser(url: str) -> None:
    """Open a page, where there is a display and a browser; waits for it."""
    # Without a display the module would take one that runs in the terminal.
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        webbrowser.open(url)
