"""The lightest subscriber of ROS 1: a socket to each publisher, read without a client library.

It observes all ROS 1 peers alike, so differences between them are their own, and adds no queue.
Protocols: wiki.ros.org/ROS/Master_API, Slave_API, TCPROS.
"""

import contextlib
import socket
import struct
import threading
import time
import xmlrpc.client
import xmlrpc.server
from typing import Any, Callable, Dict, Iterator, List, Set, Tuple

import rosgraph
from rosgraph.network import encode_ros_handshake_header

#: Reader of a new connection; called in a thread of its own.
Reader = Callable[[socket.socket], None]

#: Longest time for a connection [s].
CONNECT_LIMIT = 10.0


class Node:
    """A node with any number of subscriptions.

    :param name: global name
    :param master_uri: URI of the master

    :ivar master: the Master API, called in this node's name
    """

    def __init__(self, name: str, master_uri: str) -> None:
        self.master = rosgraph.Master(name, master_uri)
        self._name = name
        self._lock = threading.Lock()
        self._subscribed: Dict[str, Tuple[str, Reader]] = {}
        self._connected: Set[Tuple[str, str]] = set()
        self._sockets: List[socket.socket] = []
        self._is_closed = False
        self._server = xmlrpc.server.SimpleXMLRPCServer(("localhost", 0), logRequests=False)
        update: Any = self.update_publishers
        self._server.register_function(update, "publisherUpdate")
        self._uri = f"http://localhost:{self._server.server_address[1]}"
        threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True).start()

    def subscribe(self, topic: str, type_name: str, reader: Reader) -> None:
        """Connect to the publishers of a topic, now and later."""
        self._subscribed[topic] = type_name, reader
        self._connect_to(topic, self.master.registerSubscriber(topic, type_name, self._uri))

    def update_publishers(self, _caller: str, topic: str, uris: List[str]) -> Tuple[int, str, int]:
        """Connect to new publishers; called by the master."""
        with self._lock:  # a later publisher may get the port of one that has ended
            self._connected = {one for one in self._connected if one[0] != topic or one[1] in uris}
        self._connect_to(topic, uris)
        return 1, "", 0

    def close(self) -> None:
        """Close all connections and leave the graph."""
        for topic in list(self._subscribed):
            with contextlib.suppress(OSError, rosgraph.MasterException):
                self.master.unregisterSubscriber(topic, self._uri)
        self._server.shutdown()
        self._server.server_close()
        with self._lock:
            self._is_closed = True
            for connection in self._sockets:
                with contextlib.suppress(OSError):
                    connection.shutdown(socket.SHUT_RDWR)  # wakes up its reader

    def _connect_to(self, topic: str, uris: List[str]) -> None:
        with self._lock:
            new = [uri for uri in uris if (topic, uri) not in self._connected]
            self._connected.update((topic, uri) for uri in new)
        for uri in new:
            threading.Thread(target=self._connect, args=(topic, uri), daemon=True).start()

    def _connect(self, topic: str, uri: str) -> None:
        give_up = time.monotonic() + CONNECT_LIMIT
        while time.monotonic() < give_up and not self._is_closed:
            with contextlib.suppress(Exception):  # the publisher is starting, ending or broken
                with xmlrpc.client.ServerProxy(uri) as proxy:
                    answer: Any = proxy.requestTopic(self._name, topic, [["TCPROS"]])
                _, _, (_, host, port) = answer
                with socket.create_connection((host, port), CONNECT_LIMIT) as connection:
                    self._read(connection, topic)
                    return
            time.sleep(0.02)

    def _read(self, connection: socket.socket, topic: str) -> None:
        type_name, reader = self._subscribed[topic]
        with self._lock:
            if self._is_closed:
                return
            self._sockets.append(connection)
        fields = {"callerid": self._name, "topic": topic, "type": type_name, "md5sum": "*"}
        connection.sendall(encode_ros_handshake_header({**fields, "tcp_nodelay": "1"}))
        (length,) = struct.unpack("<I", _receive(connection, 4))
        _receive(connection, length)
        connection.settimeout(None)
        with contextlib.suppress(OSError):  # closed by this side
            reader(connection)


def _receive(connection: socket.socket, size: int) -> bytes:
    data = b""
    while len(data) < size:
        more = connection.recv(size - len(data))
        if not more:
            raise OSError("the connection was closed")
        data += more
    return data


def split_messages(data: bytes) -> Tuple[List[bytes], bytes]:
    """Return the whole messages in received data, without their lengths, and the rest."""
    found, at = [], 0
    while at + 4 <= len(data):
        (length,) = struct.unpack_from("<I", data, at)
        if at + 4 + length > len(data):
            break
        found.append(data[at + 4 : at + 4 + length])
        at += 4 + length
    return found, data[at:]


def receive_messages(connection: socket.socket) -> Iterator[Tuple[float, List[bytes]]]:
    """Yield the messages of a connection as they come, with the moment [s], until it ends."""
    rest = b""
    while True:
        data = connection.recv(65536)
        now = time.monotonic()
        if not data:
            return
        found, rest = split_messages(rest + data)
        yield now, found
