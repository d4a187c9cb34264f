"""A board with a topic either way, for measurements of the link to it."""

import socket
import struct
import threading
import time
import zlib
from typing import List, Optional, Tuple

from serial_link.board.ends import PtyEnd
from serial_link.device.device import Declared, Device
from serial_link.framing.frames import OVERHEAD
from serial_link.negotiation.payloads import PUBLISHER, SUBSCRIBER, Values

from .observers import wait_until
from .peer_programs import WORKSPACE
from .tcpros import Node, TopicType

NODE = WORKSPACE / "devel" / "lib" / "serial_link" / "serial_node.py"
OUT, IN = "/from_board", "/to_board"
UINT64 = TopicType("std_msgs/UInt64", "1b2a79973e8bf53d7b53acb71299cb57", "uint64 data")
#: A message, and how long its frame is, bytes.
VALUE, LENGTH = struct.Struct("<Q"), struct.Struct("<I")
FRAME = OVERHEAD + VALUE.size


def numbered(number: int) -> bytes:
    """Return a message that tells whether it is whole: a number of 32 bits, and its checksum."""
    return VALUE.pack(number << 32 | zlib.crc32(LENGTH.pack(number)))


def number_of(payload: bytes) -> Optional[int]:
    """Return the number of a message; None where it is not whole."""
    (value,) = VALUE.unpack(payload)
    number = int(value) >> 32
    return number if numbered(number) == payload else None


class PlainSketch:
    """A topic that it publishes when it is told to, and one that it listens to.

    :ivar heard: moment of each message that has come, s, and the message
    """

    topics = (
        Declared(PUBLISHER, OUT, UINT64.name, UINT64.md5sum),
        Declared(SUBSCRIBER, IN, UINT64.name, UINT64.md5sum),
    )

    def __init__(self) -> None:
        self.heard: List[Tuple[float, bytes]] = []

    def on_message(self, device: Device, now: float, name: str, payload: bytes) -> None:
        """Keep a message."""
        self.heard.append((now, payload))

    def on_parameter(self, device: Device, now: float, values: Values) -> None:
        """Have no use for parameters."""

    def loop(self, device: Device, now: float) -> None:
        """Do nothing by itself."""

    def next_due(self, now: float) -> float:
        """Return when something is due, s: hardly ever."""
        return now + 1.0


class PlainBoard:
    """A board whose line takes no time, so that what is measured is the host's part.

    :param link: path of the link to its port
    """

    def __init__(self, link: str) -> None:
        self.sketch = PlainSketch()
        self._device = Device(self.sketch)
        self._end = PtyEnd(link)
        self._lock = threading.Lock()
        self._is_over = False
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> "PlainBoard":
        self._end.plug()
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._is_over = True
        self._thread.join()
        self._end.unplug()

    def wait_until_asked(self) -> None:
        """Wait until the host knows its topics."""
        wait_until(lambda: self._device.is_configured, 30.0, "host that asks for the topics")

    def send(self, payload: bytes) -> None:
        """Publish a message."""
        with self._lock:
            self._device.publish(OUT, payload)
            self._end.write(self._device.output())

    def _run(self) -> None:
        while not self._is_over:
            self._end.wait(0.1)
            now, data = time.monotonic(), self._end.read()
            with self._lock:
                self._device.receive(now, data)
                self._device.loop(now)
                self._end.write(self._device.output())


class Sender:
    """Publishes to the board, as a node of ROS does.

    :param node: on whose behalf
    """

    def __init__(self, node: Node) -> None:
        self._connection: Optional[socket.socket] = None
        node.advertise(IN, UINT64, self._start)

    def wait(self) -> None:
        """Wait until the link listens."""
        wait_until(lambda: self._connection is not None, 30.0, "subscriber of " + IN)

    def send(self, payload: bytes) -> None:
        """Publish a message."""
        assert self._connection is not None
        self._connection.sendall(LENGTH.pack(len(payload)) + payload)

    def _start(self, connection: socket.socket) -> None:
        self._connection = connection
