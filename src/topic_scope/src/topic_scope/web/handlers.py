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

from topic_scope.page.open_page import Page
from topic_scope.protocol.checks import RequestError
from topic_scope.protocol.export_request import export_of
from topic_scope.protocol.image_request import image_request_of
from topic_scope.protocol.options import Options
from topic_scope.protocol.requests import LONGEST
from topic_scope.web import access

#: Where Debian installs dygraphs.
DYGRAPHS = "/usr/share/javascript/dygraphs"
#: Most pages at a time.
PAGES = 32
#: WebSocket close code if there are more: try again later.
TRY_AGAIN = 1013
#: Send buffer of a page that does not read [bytes]; by default it may grow to megabytes.
_SEND_BUFFER = 256 * 1024


class ScopeHolder:
    """Holder of the current scope, which is replaced once the master answers.

    :ivar scope: object with ``sockets``, ``open``, ``close``, ``handle``, ``export`` and ``image``
    """

    def __init__(self, scope: Any) -> None:
        self.scope = scope


def bind(options: Options) -> List[socket.socket]:
    """Return the listening sockets.

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
    """Set headers that forbid loading other sites' content and framing."""
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
    """Handler of the files of one folder; rejects paths outside of it."""

    def prepare(self) -> None:
        _check_host(self)

    def set_default_headers(self) -> None:
        set_strict_headers(self)


class CsvData(tornado.web.RequestHandler):
    """Handler of CSV exports.

    :param holder: holder of the current scope
    """

    def initialize(self, holder: ScopeHolder) -> None:
        self._scope = holder.scope

    def prepare(self) -> None:
        _check_host(self)

    def set_default_headers(self) -> None:
        set_strict_headers(self)

    async def get(self) -> None:
        """Send the samples of fields in a time span."""
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
            pass  # the page has closed the connection


class ImageData(tornado.web.RequestHandler):
    """Handler of requests for images.

    The response header Image-Description describes the image or the problem, as JSON.

    :param holder: holder of the current scope
    """

    def initialize(self, holder: ScopeHolder) -> None:
        self._scope = holder.scope

    def prepare(self) -> None:
        _check_host(self)

    def set_default_headers(self) -> None:
        set_strict_headers(self)

    async def get(self) -> None:
        """Send the image of a topic at a time, unless the page already has it."""
        names = [name for name in ("topic", "time", "known") if self.get_arguments(name)]
        try:
            wanted = image_request_of({name: self.get_argument(name) for name in names})
        except RequestError as error:
            raise tornado.web.HTTPError(400, str(error)) from None
        description, file = await self._scope.image(wanted)
        self.set_header("Cache-Control", "no-store")
        self.set_header("Cross-Origin-Resource-Policy", "same-origin")  # not for other sites
        self.set_header("Image-Description", json.dumps(description))
        if file is None:
            self.set_status(204)
            return
        self.set_header("Content-Type", file.media_type)
        self.write(file.data)


class PageSocket(tornado.websocket.WebSocketHandler):
    """WebSocket of one page.

    :param holder: holder of the current scope
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
        if len(self._holder.scope.sockets) >= PAGES:  # browsers show only the close reason
            self.close(TRY_AGAIN, f"{PAGES} pages of this scope are open already: close one")
            return
        self.enter()

    def enter(self) -> None:
        """Attach the page to the current scope."""
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

    :param holder: holder of the current scope
    :param folder: folder of the page's files
    :param names: names of this machine
    """
    return tornado.web.Application(
        [
            (r"/ws", PageSocket, {"holder": holder}),
            (r"/data\.csv", CsvData, {"holder": holder}),
            (r"/image", ImageData, {"holder": holder}),
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
    """Start serving pages, in the event loop of the calling thread.

    :param options: the command line
    :param sockets: listening sockets
    :param holder: holder of the current scope
    """
    # roslib runs rospack, which a Ctrl-C at that moment would end as well.
    folder = os.path.join(rospkg.RosPack().get_path("topic_scope"), "www")
    names = access.names_of(socket.gethostname(), socket.getfqdn(), options.address)
    server = tornado.httpserver.HTTPServer(
        application(holder, folder, names), max_header_size=16384, max_body_size=4096
    )
    server.add_sockets(sockets)


def open_browser(url: str) -> None:
    """Open a page, if there is a display and a browser; waits for the browser."""
    # Without a display the module would start a browser in the terminal.
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        webbrowser.open(url)
