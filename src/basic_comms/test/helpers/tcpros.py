"""The wire of ROS topics by hand: connections to a node as any program can make them."""

import itertools
import socket
import struct
from typing import Any, Dict, Tuple
from xmlrpc.client import ServerProxy

from rosgraph.network import encode_ros_handshake_header

from nodekit.testing.waiting import TIMEOUT_S

_LENGTH = struct.Struct("<I")
# Each has its own name: rospy closes the older of two connections with the same name.
_NUMBERS = itertools.count()


def address(node_uri: str, topic: str = "/rosout") -> Tuple[str, int]:
    """Ask a node for the address at which it publishes a topic; every node publishes /rosout.

    :param node_uri: URI of the node's XML-RPC port
    """
    with ServerProxy(node_uri) as node:
        answer: Any = node.requestTopic("/by_hand", topic, [["TCPROS"]])
    return str(answer[2][1]), int(answer[2][2])


def header(topic: str, kind: Any, **changes: str) -> bytes:
    """Return a subscriber's connection header.

    :param topic: the topic's global name
    :param kind: class of its messages
    :param changes: fields with other values
    """
    fields: Dict[str, str] = {
        "callerid": f"/by_hand_{next(_NUMBERS)}",
        "topic": topic,
        "type": kind._type,
        "md5sum": kind._md5sum,
    }
    return bytes(encode_ros_handshake_header({**fields, **changes}))


def connect(where: Tuple[str, int]) -> socket.socket:
    """Open a connection that gives up reading after the usual time-out."""
    return socket.create_connection(where, TIMEOUT_S)


class Tap:
    """Subscriber that reads only on request.

    :param node_uri: URI of the publishing node's XML-RPC port
    :param topic: the topic's global name
    :param kind: class of its messages
    """

    def __init__(self, node_uri: str, topic: str, kind: Any) -> None:
        self._kind = kind
        self._socket = connect(address(node_uri, topic))
        self._socket.sendall(header(topic, kind))
        self._stream = self._socket.makefile("rb")
        self.answer = self._block()

    def read(self) -> Any:
        """Wait for the next message.

        :raises ConnectionError: if the connection ended
        """
        return self._kind().deserialize(self._block())

    def close(self) -> None:
        """Hang up."""
        self._stream.close()
        self._socket.close()

    def _block(self) -> bytes:
        size = self._stream.read(_LENGTH.size)
        if len(size) < _LENGTH.size:
            raise ConnectionError("the node has hung up")
        return self._stream.read(_LENGTH.unpack(size)[0])
