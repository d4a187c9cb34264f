"""Subscribers that keep no messages, only what they tell."""

import socket
import struct
import threading
import time
from typing import Callable, Optional

from ..benchmark.tcpros import Node, split_messages
from .streams import Arrivals, Continuity

#: where time_x stands in a basic_comms/signal_msg
TIME_X = struct.Struct("<8xd")

SIGNAL, ANSWER, TEXT, LOG = (
    "basic_comms/signal_msg",
    "std_msgs/Float32",
    "std_msgs/String",
    "rosgraph_msgs/Log",
)


class Watch:
    """Watches a topic, over any number of connections one after the other.

    :param node: on whose behalf
    :param topic: global name
    :param type_name: of its messages
    :param rate: how many a second, 1/s; given, what is missing in a signal is counted
    :param keep: whether a message counts; all do unless given
    """

    def __init__(
        self,
        node: Node,
        topic: str,
        type_name: str,
        rate: Optional[float] = None,
        keep: Optional[Callable[[bytes], bool]] = None,
    ) -> None:
        self.topic = topic
        self.arrivals = Arrivals()
        self.continuity = Continuity(1.0 / rate) if rate else None
        self.connections = 0
        self._keep = keep
        self._lock = threading.Lock()
        node.subscribe(topic, type_name, self._start)

    def restart(self) -> None:
        """Forget the silences so far."""
        with self._lock:
            self.arrivals = Arrivals()

    def _start(self, connection: socket.socket) -> None:
        self.connections += 1
        threading.Thread(target=self._read, args=(connection,), daemon=True).start()

    def _read(self, connection: socket.socket) -> None:
        rest = b""
        while True:
            try:
                data = connection.recv(65536)
            except OSError:
                return  # closed by this side
            now = time.monotonic()
            if not data:
                return
            messages, rest = split_messages(rest + data)
            if self._keep is not None:
                messages = [message for message in messages if self._keep(message)]
            with self._lock:
                if messages:
                    self.arrivals.add(now, len(messages))
                if self.continuity is not None:
                    for message in messages:
                        self.continuity.add(TIME_X.unpack_from(message)[0])
