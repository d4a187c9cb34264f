"""WebSocket client of a page, and HTTP requests, for tests."""

import asyncio
import json
import socket
import struct
import threading
import time
import urllib.error
import urllib.parse
import urllib.request
from typing import Any, Callable, Dict, List, Optional, Tuple

import tornado.httpclient
import tornado.ioloop
import tornado.websocket

from nodekit.testing.waiting import TIMEOUT_S, wait_until

Message = Dict[str, Any]


class Client:
    """Page that stores all messages, and joins frames like a page.

    :param url: URL of the scope
    :param headers: additional headers of the request
    :raises Exception: if the scope rejects the connection
    """

    def __init__(self, url: str, headers: Optional[Dict[str, str]] = None) -> None:
        self.bins: Dict[str, Dict[int, List[Optional[float]]]] = {}
        self.width = 0.0
        self._messages: List[Message] = []
        self._lock = threading.Lock()
        self._ready = threading.Event()
        self._failure: Optional[BaseException] = None
        self._closed = False
        self._request = tornado.httpclient.HTTPRequest(
            url.replace("http", "ws", 1) + "/ws", headers=headers or {}, connect_timeout=TIMEOUT_S
        )
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        self._ready.wait(TIMEOUT_S)
        if self._failure is not None:
            raise self._failure

    def _run(self) -> None:
        asyncio.set_event_loop(asyncio.new_event_loop())
        self._loop = tornado.ioloop.IOLoop.current()
        try:
            self._loop.run_sync(self._read)
        except BaseException as error:
            self._failure = error
        self._ready.set()

    async def _read(self) -> None:
        self._connection = await tornado.websocket.websocket_connect(self._request)
        self._connection.protocol.set_nodelay(True)  # as in browsers
        self._ready.set()
        while True:
            text = await self._connection.read_message()
            if text is None:
                self._closed = True
                return
            with self._lock:
                self._add_message(json.loads(text, parse_constant=_refuse))

    def _add_message(self, message: Message) -> None:
        message["heard"] = time.monotonic()
        self._messages.append(message)
        if message["type"] == "frame":
            if message["reset"]:
                self.bins = {}
            self.width = message["bin"]
            for field, values in message["traces"].items():
                bins = self.bins.setdefault(field, {})
                for index in range(len(values) // 2):
                    bins[message["first"] + index] = values[2 * index : 2 * index + 2]

    def send(self, kind: str, **content: Any) -> None:
        """Send a request."""
        self.send_text(json.dumps({"type": kind, **content}))

    def send_text(self, text: Any) -> None:
        """Send anything."""
        binary = isinstance(text, bytes)
        self._loop.add_callback(lambda: self._connection.write_message(text, binary=binary))

    def messages(self, kind: str) -> List[Message]:
        """Return the received messages of a type, oldest first."""
        with self._lock:
            return [message for message in self._messages if message["type"] == kind]

    def forget(self) -> None:
        """Drop the received messages, but not the screen."""
        with self._lock:
            self._messages.clear()

    def wait_for(self, kind: str, condition: Callable[[Message], bool] = lambda _: True) -> Message:
        """Return the first message that meets a condition, among received and future messages."""
        return wait_until(
            lambda: [message for message in self.messages(kind) if condition(message)][:1],
            lambda: f"of {kind} came {str(self.messages(kind)[-3:])[:2000]}",
        )[0]

    def bins_of(self, field: str) -> Dict[int, List[Optional[float]]]:
        """Return the bins of a field on the screen, unchanged by further frames."""
        with self._lock:
            return dict(self.bins.get(field, {}))

    def values(self, field: str) -> List[float]:
        """Return all extremes of a field on the screen, by time."""
        pairs = (pair for _, pair in sorted(self.bins_of(field).items()))
        return [
            value for pair in pairs for value in pair if value is not None and value is not False
        ]

    @property
    def is_closed(self) -> bool:
        """Whether the scope has closed the connection."""
        return self._closed

    @property
    def farewell(self) -> Tuple[Optional[int], Optional[str]]:
        """Code and reason with which the scope has closed the connection."""
        return self._connection.close_code, self._connection.close_reason

    def cut(self) -> None:
        """Drop the connection without closing it."""

        def cut() -> None:
            stream = self._connection.protocol.stream
            linger = struct.pack("ii", 1, 0)
            stream.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
            stream.close()

        self._loop.add_callback(cut)

    def close(self) -> None:
        """Close the connection."""
        self._loop.add_callback(lambda: self._connection.close())
        self._thread.join(TIMEOUT_S)


def fetch(url: str, headers: Optional[Dict[str, str]] = None) -> Tuple[int, str]:
    """Return status and text of a response.

    :param url: the URL, sent unchanged, even with ..
    :param headers: headers of the request
    """
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers or {})) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def fetch_image(url: str, topic: str, **query: str) -> Tuple[Message, str, bytes]:
    """Return description, media type and file of an image; empty without a file.

    :param url: URL of the scope
    :param topic: topic of the image
    :param query: ``time`` or ``known``
    """
    text = urllib.parse.urlencode({"topic": topic, **query})
    with urllib.request.urlopen(f"{url}/image?{text}", timeout=TIMEOUT_S) as answer:
        kind = answer.headers.get("Content-Type") or ""
        return json.loads(answer.headers["Image-Description"]), kind, answer.read()


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is no JSON")
