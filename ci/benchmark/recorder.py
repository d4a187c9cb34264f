"""Lightweight ROS 1 subscriber: a socket to each publisher, read without a client library.

It treats all ROS 1 peers alike, and adds no queue.
Protocols: wiki.ros.org/ROS/Master_API, Slave_API, TCPROS.
"""

import contextlib
import io
import socket
import struct
import threading
import time
import xmlrpc.client
import xmlrpc.server
from typing import Any, Callable, List, Set, Tuple

import rosgraph
from rosgraph.network import encode_ros_handshake_header, read_ros_handshake_header

from .record import Sample

#: Longest time for a connection [s].
CONNECT_LIMIT = 10.0
#: Layout of a message from its start, and the number of its value, by type.
VALUES = {
    "std_msgs/Float32": ("<f", 0),
    "basic_comms/signal_msg": ("<ffdf", 3),
    "pid_control/motor_input": ("<fd", 1),
}


class Recorder:
    """Node that keeps each message of one topic with its time of arrival.

    A thread waits in the kernel for the messages of each publisher.

    :param name: of the node, global
    :param master_uri: URI of the master
    :param topic: global name
    :param type_name: its type

    :ivar messages: moment [s] and serialized message of each arrival
    """

    def __init__(self, name: str, master_uri: str, topic: str, type_name: str) -> None:
        self.messages: List[Tuple[float, bytes]] = []
        self._master = rosgraph.Master(name, master_uri)
        self._name, self._topic, self._type = name, topic, type_name
        self._lock = threading.Lock()
        self._publishers: Set[str] = set()
        self._sockets: List[socket.socket] = []
        self._is_closed = False
        self._server = xmlrpc.server.SimpleXMLRPCServer(("localhost", 0), logRequests=False)
        update: Any = self._update
        self._server.register_function(update, "publisherUpdate")
        self._uri = f"http://localhost:{self._server.server_address[1]}"
        threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True).start()
        self.update_publishers(self._master.registerSubscriber(topic, type_name, self._uri))

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(self, *_error: object) -> None:
        """Close all connections and leave the graph."""
        with contextlib.suppress(OSError, rosgraph.MasterException):
            self._master.unregisterSubscriber(self._topic, self._uri)
        self._server.shutdown()
        self._server.server_close()
        with self._lock:
            self._is_closed = True
            for connection in self._sockets:
                with contextlib.suppress(OSError):
                    connection.shutdown(socket.SHUT_RDWR)  # wakes up its reader

    def _update(self, _caller: str, _topic: str, uris: List[str]) -> Tuple[int, str, int]:
        self.update_publishers(uris)
        return 1, "", 0

    def update_publishers(self, uris: List[str]) -> None:
        """Connect to new publishers, which may reuse the port of an ended publisher."""
        with self._lock:
            new = set(uris) - self._publishers
            self._publishers = set(uris)
        for uri in new:
            threading.Thread(target=self._connect, args=(uri,), daemon=True).start()

    def _connect(self, uri: str) -> None:
        deadline = time.monotonic() + CONNECT_LIMIT
        while time.monotonic() < deadline and not self._is_closed:
            with contextlib.suppress(Exception):  # the publisher is starting, ending or broken
                with xmlrpc.client.ServerProxy(uri) as proxy:
                    answer: Any = proxy.requestTopic(self._name, self._topic, [["TCPROS"]])
                _, _, (_, host, port) = answer
                with socket.create_connection((host, port), CONNECT_LIMIT) as connection:
                    self._read(connection)
                    return
            time.sleep(0.02)

    def _read(self, connection: socket.socket) -> None:
        fields = {"callerid": self._name, "topic": self._topic, "type": self._type, "md5sum": "*"}
        connection.sendall(encode_ros_handshake_header({**fields, "tcp_nodelay": "1"}))
        received = io.BytesIO()
        read_ros_handshake_header(connection, received, 65536)
        connection.settimeout(None)
        with self._lock:
            if self._is_closed:
                return
            self._sockets.append(connection)
        data, now = received.getvalue(), time.monotonic()
        while True:
            found, rest = split_messages(data)
            self.messages += [(now, message) for message in found]
            more, now = connection.recv(65536), time.monotonic()
            if not more:
                return
            data = rest + more

    def samples(self) -> List[Sample]:
        """Return time and value of each message."""
        layout, field = VALUES[self._type]
        return [
            Sample(moment, struct.unpack_from(layout, message)[field])
            for moment, message in list(self.messages)
        ]

    def wait(self, count: int = 1) -> float:
        """Wait for some messages, and return the arrival time of the first [s]."""
        wait_until(lambda: len(self.messages) >= count, 30.0, "messages")
        return self.messages[0][0]


def split_messages(data: bytes) -> Tuple[List[bytes], bytes]:
    """Return the complete messages in received data, without their lengths, and the rest."""
    found, at = [], 0
    while at + 4 <= len(data):
        (length,) = struct.unpack_from("<I", data, at)
        if at + 4 + length > len(data):
            break
        found.append(data[at + 4 : at + 4 + length])
        at += 4 + length
    return found, data[at:]


def wait_until(condition: Callable[[], object], limit: float, what: str) -> None:
    """Wait for a condition.

    :param limit: longest wait [s]
    :raises TimeoutError: if the condition does not become true
    """
    deadline = time.monotonic() + limit
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"no {what} within {limit:g} s")
        time.sleep(0.01)
