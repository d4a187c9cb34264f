"""Limits: number of pages, exports, and a page that does not read."""

import base64
import json
import os
import socket
import time
import urllib.parse
from typing import Any, Dict

import rospy
from geometry_msgs.msg import Point, PointStamped
from std_msgs.msg import Float32, Header
from wire.client import Client, fetch
from wire.scope_test import ScopeTest

from nodekit.testing.waiting import wait_until

FIELDS = [f"/signal/{name}" for name in ("signal_y", "time_x", "amplitude", "frequency")]


class Guards(ScopeTest):
    """Scope for this machine only."""

    ARGUMENTS = [*FIELDS, "--history", "3"]

    def test_bad_exports_are_rejected(self) -> None:
        for query in (
            "field=../x",
            "field=" + "&field=".join(f"/a/x{n}" for n in range(40)),
            "field=/a/x&start=nan",
            "field=/a/x&end=soon",
            "field=" + "a" * 400,
        ):
            self.assertEqual(fetch(f"{self.scope.url}/data.csv?{query}")[0], 400, query)

    def test_invalid_name_has_an_empty_column_in_an_export(self) -> None:
        for name in ("../x", "a" * 400, "/a/x.nonsense", "/a b"):
            query = urllib.parse.urlencode([("field", FIELDS[0]), ("field", name)])
            status, text = fetch(f"{self.scope.url}/data.csv?{query}")
            self.assertEqual(status, 200, name)
            self.assertEqual(text.splitlines()[0], f"time,received,{FIELDS[0]},{name}")

    def test_number_of_pages_is_limited(self) -> None:
        for _ in range(32):  # pages of previous tests may still be open
            wait_until(self.is_let_in, lambda: "there is no place for a page")
        late = Client(self.scope.url)
        wait_until(lambda: late.is_closed, lambda: "one more page is let in")
        sentence = "32 pages of this scope are open already: close one"
        self.assertEqual(late.farewell, (1013, sentence))
        self.doCleanups()
        wait_until(self.is_let_in, lambda: "the place of a page that has gone is not free")

    def is_let_in(self) -> bool:
        """Open a page, which costs nothing from then on, and return whether that worked."""
        page = NotReading(self.scope.url)
        self.addCleanup(page.close)
        return page.is_greeted()

    def test_paused_view_is_kept_longer_than_the_history(self) -> None:
        field = "/pinned/point/x@stamp"
        page = self.page(field)
        publisher = self.publisher("/pinned", PointStamped, page)
        now = time.time()

        def publish(after: float) -> None:
            stamp = rospy.Time.from_sec(now + after)
            publisher.publish(PointStamped(Header(stamp=stamp), Point(x=after)))

        for index in range(20):
            publish(0.01 * index)
        wait_until(lambda: self.rows(field) == 20, lambda: self.rows(field))
        page.send("view", window=2.0, width=100, end=now + 1.0)
        page.wait_for("frame", lambda frame: frame["reset"] and frame["bin"] == 0.02)
        # A minute passes by the stamps; the history is three seconds. A stamp so far ahead counts
        # only once others confirm it.
        begin = time.monotonic()

        def is_later() -> bool:
            publish(60.0 + time.monotonic() - begin)
            return self.rows(field, start=now + 30.0) > 2

        wait_until(is_later, lambda: self.rows(field))
        self.assertEqual(self.rows(field, end=now + 30.0), 20, "those that are shown")
        page.send("view", window=2.0, width=100, end=None)
        wait_until(lambda: self.rows(field, end=now + 30.0) == 0, lambda: self.rows(field))

    def rows(self, field: str, start: float = 0.0, end: float = 1e10) -> int:
        """Return the number of samples in the CSV of a span."""
        query = f"field={field}&start={start}&end={end}"
        _, text = fetch(f"{self.scope.url}/data.csv?{query}")
        return len(text.splitlines()) - 1

    def test_unused_topic_is_unsubscribed(self) -> None:
        page = self.page("/left/data")
        publisher = self.publisher("/left", Float32, page)
        page.send("select", fields=FIELDS)
        wait_until(lambda: publisher.get_num_connections() == 0, lambda: "still subscribed")

    def test_a_page_that_does_not_read_gets_no_backlog(self) -> None:
        """It continuously requests large frames, and reads none."""
        fast, slow = self.page(), NotReading(self.scope.url)
        self.addCleanup(slow.close)
        before = self.memory()
        for _ in range(150):
            slow.send(type="view", window=60.0, width=4000, end=None)
            time.sleep(0.02)
        fast.forget()
        fast.wait_for("frame")
        self.assertLess(self.memory() - before, 20e6)
        # It now reads the data in the system's buffer, and then the present.
        asked_at = time.time()
        old = 0
        for message in slow.messages():
            if message["type"] == "frame":
                if message["now"] > asked_at:
                    break
                old += 1
        self.assertLess(old, 75)

    def memory(self) -> int:
        """Return the memory of the scope [bytes]."""
        with open(f"/proc/{self.scope.pid}/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


class ReadOnly(ScopeTest):
    """A scope that is open to the network."""

    ARGUMENTS = ["/signal/signal_y", "--address", "0.0.0.0"]

    def test_scope_is_reached_by_address_but_not_by_a_foreign_name(self) -> None:
        port = urllib.parse.urlsplit(self.scope.url).port
        address = f"http://{socket.gethostbyname(socket.gethostname())}:{port}/"
        self.assertEqual(fetch(address)[0], 200)
        self.assertEqual(fetch(address, {"Host": "example.com"})[0], 403)


class NotReading:
    """Page that sends, and reads only on request."""

    def __init__(self, url: str) -> None:
        parts = urllib.parse.urlsplit(url)
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65536)
        self._socket.settimeout(30.0)
        self._socket.connect((parts.hostname, parts.port))
        key = base64.b64encode(bytes(16)).decode()
        head = "GET /ws HTTP/1.1\r\nHost: %s\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        head += "Sec-WebSocket-Key: %s\r\nSec-WebSocket-Version: 13\r\n\r\n"
        self._socket.sendall((head % (parts.netloc, key)).encode())
        self._file = self._socket.makefile("rb")
        while self._file.readline().strip():
            pass

    def send(self, **request: Any) -> None:
        data = json.dumps(request).encode()
        self._socket.sendall(bytes([0x81, 0x80 | len(data), 0, 0, 0, 0]) + data)

    def is_greeted(self) -> bool:
        """Return whether the server begins with a message, and not with the end."""
        return bool(self._file.peek(1)[:1] == b"\x81")

    def messages(self) -> Any:
        """Yield the messages as they are read."""
        while True:
            first, length = self._file.read(2)
            if length == 126:
                length = int.from_bytes(self._file.read(2), "big")
            elif length == 127:
                length = int.from_bytes(self._file.read(8), "big")
            data = self._file.read(length)
            if first == 0x81:
                message: Dict[str, Any] = json.loads(data)
                yield message

    def close(self) -> None:
        self._socket.close()
