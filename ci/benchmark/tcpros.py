"""A node that speaks ROS 1's protocols itself: the lightest subscriber and publisher there can be.

All ROS 1 peers are watched by, and under load fed by, this same node, so that differences
between them are their own. Protocols: wiki.ros.org/ROS/Master_API, Slave_API, TCPROS.
"""

import contextlib
import http.client
import os
import socket
import socketserver
import struct
import sys
import threading
import time
import xml.parsers.expat
import xmlrpc.client
import xmlrpc.server
from typing import Any, Callable, Dict, List, NamedTuple, Set, Tuple

#: A new connection's socket; its messages have not been read yet.
Handler = Callable[[socket.socket], None]

#: how long a connection may take to come about, s
CONNECT_LIMIT = 10.0
#: how long a node may take to close, s
CLOSING_LIMIT = 0.5
#: the longest header that is read, bytes
HEADER_LIMIT = 1 << 20
#: what comes of peers that hang up, answer nonsense, or speak of what nobody knows
FAULTS_OF_PEERS = (
    OSError,
    ValueError,
    TypeError,
    LookupError,
    struct.error,
    http.client.HTTPException,
    xmlrpc.client.Error,
    xml.parsers.expat.ExpatError,
)


class TopicType(NamedTuple):
    """What TCPROS says about a topic's messages."""

    name: str
    md5sum: str = "*"
    definition: str = ""


def encode_header(fields: Dict[str, str]) -> bytes:
    """Return a connection header as it goes on the wire."""
    lines = [f"{name}={value}".encode() for name, value in fields.items()]
    body = b"".join(struct.pack("<I", len(line)) + line for line in lines)
    return struct.pack("<I", len(body)) + body


def decode_header(body: bytes) -> Dict[str, str]:
    """Return the fields of a connection header, given without its length."""
    fields = {}
    while body:
        (length,) = struct.unpack_from("<I", body)
        name, _, value = body[4 : 4 + length].decode().partition("=")
        fields[name] = value
        body = body[4 + length :]
    return fields


def split_messages(data: bytes) -> Tuple[List[bytes], bytes]:
    """Take apart what a connection has delivered.

    :returns: the whole messages, without their lengths, and the incomplete rest
    """
    messages = []
    at = 0
    while at + 4 <= len(data):
        (length,) = struct.unpack_from("<I", data, at)
        if at + 4 + length > len(data):
            break
        messages.append(data[at + 4 : at + 4 + length])
        at += 4 + length
    return messages, data[at:]


class _SlaveServer(socketserver.ThreadingMixIn, xmlrpc.server.SimpleXMLRPCServer):
    daemon_threads = True
    request_queue_size = 128

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Keep quiet about a peer that hangs up before it has its answer."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


class Node:
    """A node with any number of subscriptions and publications.

    :param name: global name
    :param master_uri: where the master is
    """

    def __init__(self, name: str, master_uri: str) -> None:
        self._name = name
        self._master_uri = master_uri
        self._lock = threading.Lock()
        self._subscribed: Dict[str, Tuple[TopicType, Handler]] = {}
        self._connected: Set[Tuple[str, str]] = set()
        self._advertised: Dict[str, Tuple[TopicType, Handler]] = {}
        self._sockets: List[socket.socket] = []
        self._closed = False
        self._listener = socket.create_server(("localhost", 0), backlog=64)
        self._server = _SlaveServer(("localhost", 0), allow_none=True, logRequests=False)
        slave_api: List[Any] = [self.publisherUpdate, self.requestTopic, self.getPid]
        for function in slave_api:
            self._server.register_function(function)
        self._uri = f"http://localhost:{self._server.server_address[1]}"
        threading.Thread(
            target=self._server.serve_forever, args=(CLOSING_LIMIT,), daemon=True
        ).start()
        threading.Thread(target=self._accept, daemon=True).start()

    def master(self, method: str, *arguments: Any) -> Any:
        """Call the master.

        :param method: of the Master API
        :param arguments: those after the caller's name
        :raises RuntimeError: if the master refuses
        """
        with xmlrpc.client.ServerProxy(self._master_uri, allow_none=True) as proxy:
            answer: Any = getattr(proxy, method)(self._name, *arguments)
        code, message, value = answer
        if code != 1:
            raise RuntimeError(f"{method}: {message}")
        return value

    def subscribe(self, topic: str, type_name: str, handler: Handler) -> None:
        """Have each connection to a publisher of a topic handed to a function."""
        self._subscribed[topic] = TopicType(type_name), handler
        uris = self.master("registerSubscriber", topic, type_name, self._uri)
        self._connect_to(topic, uris)

    def advertise(self, topic: str, topic_type: TopicType, handler: Handler) -> None:
        """Have each connection from a subscriber to a topic handed to a function."""
        self._advertised[topic] = topic_type, handler
        self.master("registerPublisher", topic, topic_type.name, self._uri)

    def close(self) -> None:
        """End all connections and leave the graph."""
        for topic in list(self._subscribed):
            with contextlib.suppress(OSError, RuntimeError):
                self.master("unregisterSubscriber", topic, self._uri)
        for topic in list(self._advertised):
            with contextlib.suppress(OSError, RuntimeError):
                self.master("unregisterPublisher", topic, self._uri)
        self._server.shutdown()
        self._server.server_close()
        with self._lock:
            self._closed = True
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)  # or else accept() waits on
        self._listener.close()
        for connection in self._sockets:
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)
            connection.close()

    # --- called by the master and by other nodes; the names are the Slave API's

    def publisherUpdate(self, _caller: str, topic: str, uris: List[str]) -> Tuple[int, str, int]:
        """Connect to publishers that are new."""
        with self._lock:  # one that comes later may get the port of one that has gone
            self._connected = {
                (other, uri) for other, uri in self._connected if other != topic or uri in uris
            }
        self._connect_to(topic, uris)
        return 1, "", 0

    def requestTopic(self, _caller: str, _topic: str, _protocols: Any) -> Tuple[int, str, Any]:
        """Tell where to connect to."""
        return 1, "", ["TCPROS", "localhost", self._listener.getsockname()[1]]

    def getPid(self, _caller: str) -> Tuple[int, str, int]:
        """Tell the number of this process."""
        return 1, "", os.getpid()

    # --- connections

    def _connect_to(self, topic: str, uris: List[str]) -> None:
        for uri in uris:
            with self._lock:
                if (topic, uri) in self._connected:
                    continue
                self._connected.add((topic, uri))
            threading.Thread(target=self._connect, args=(topic, uri), daemon=True).start()

    def _connect(self, topic: str, uri: str) -> None:
        topic_type, handler = self._subscribed[topic]
        give_up = time.monotonic() + CONNECT_LIMIT
        while time.monotonic() < give_up and not self._closed:
            connection = None
            try:
                with xmlrpc.client.ServerProxy(uri) as proxy:
                    answer: Any = proxy.requestTopic(self._name, topic, [["TCPROS"]])
                _, _, (_, host, port) = answer
                connection = socket.create_connection((host, port), CONNECT_LIMIT)
                connection.sendall(
                    encode_header(
                        {
                            "callerid": self._name,
                            "topic": topic,
                            "type": topic_type.name,
                            "md5sum": topic_type.md5sum,
                            "tcp_nodelay": "1",
                        }
                    )
                )
                _read_header(connection)
            except FAULTS_OF_PEERS:
                if connection is not None:
                    connection.close()
                time.sleep(0.02)  # it is starting, or it is gone
                continue
            self._hand_over(connection, handler)
            return

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            # One that sends nothing, or nonsense, holds up no other.
            threading.Thread(target=self._welcome, args=(connection,), daemon=True).start()

    def _welcome(self, connection: socket.socket) -> None:
        connection.settimeout(CONNECT_LIMIT)
        try:
            fields = _read_header(connection)
            topic_type, handler = self._advertised[fields["topic"]]
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connection.sendall(
                encode_header(
                    {
                        "callerid": self._name,
                        "topic": fields["topic"],
                        "type": topic_type.name,
                        "md5sum": topic_type.md5sum,
                        "message_definition": topic_type.definition,
                        "latching": "0",
                    }
                )
            )
        except FAULTS_OF_PEERS:
            connection.close()
            return
        self._hand_over(connection, handler)

    def _hand_over(self, connection: socket.socket, handler: Handler) -> None:
        connection.settimeout(None)
        with self._lock:
            if self._closed:
                connection.close()
                return
            self._sockets.append(connection)
        handler(connection)


def _read_header(connection: socket.socket) -> Dict[str, str]:
    (length,) = struct.unpack("<I", _read(connection, 4))
    if length > HEADER_LIMIT:
        raise ValueError(f"a header of {length} bytes")
    return decode_header(_read(connection, length))


def _read(connection: socket.socket, size: int) -> bytes:
    data = b""
    while len(data) < size:
        more = connection.recv(size - len(data))
        if not more:
            raise OSError("the connection was closed")
        data += more
    return data
