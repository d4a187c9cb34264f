"""Subscribers that keep figures of a stream, and no messages."""

import socket
import struct
import threading
from typing import Callable, Optional

from ..benchmark.tcpros import Node, receive_messages
from .streams import Arrivals, Continuity

#: Place of time_x in a basic_comms/signal_msg.
TIME_X = struct.Struct("<8xd")

SIGNAL, ANSWER, TEXT, LOG = (
    "basic_comms/signal_msg",
    "std_msgs/Float32",
    "std_msgs/String",
    "rosgraph_msgs/Log",
)


class Watch:
    """Observer of a topic, over any number of connections one after the other.

    :param node: subscribes to the topic
    :param topic: global name
    :param type_name: of its messages
    :param rate: of a signal, whose missing samples are counted [Hz]
    :param keep: whether a message counts; all do unless given
    """

    def __init__(
        self,
        node: Node,
        topic: str,
        type_name: str,
        rate: float = 0.0,
        keep: Optional[Callable[[bytes], bool]] = None,
    ) -> None:
        self.topic = topic
        self.arrivals = Arrivals()
        self.continuity = Continuity(1.0 / rate if rate else 1.0)
        self._has_times = rate > 0.0
        self._keep = keep
        self._lock = threading.Lock()
        node.subscribe(topic, type_name, self._read)

    def restart(self) -> None:
        """Forget the arrivals so far."""
        with self._lock:
            self.arrivals = Arrivals()

    def _read(self, connection: socket.socket) -> None:
        for moment, messages in receive_messages(connection):
            if self._keep is not None:
                messages = [message for message in messages if self._keep(message)]
            with self._lock:
                if messages:
                    self.arrivals.add(moment, len(messages))
                if self._has_times:
                    for message in messages:
                        self.continuity.add(TIME_X.unpack_from(message)[0])
