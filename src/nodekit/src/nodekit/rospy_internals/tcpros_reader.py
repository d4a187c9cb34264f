"""Reader of a publisher's connection; unpacks all messages of one read at once."""

import contextlib
import mmap
import socket
import struct
import time
from typing import Any, List

import genpy
import rospy.core
from rospy.exceptions import TransportException, TransportInitError, TransportTerminated
from rospy.impl.tcpros_base import TCPROSTransport

_LENGTH = struct.Struct("<I")
_PREFIX = _LENGTH.size
#: Longest time to go on reading after a message, for callbacks that want the newest [s].
_UNTIL_EMPTY_S = 0.05


class Reader:
    """Reader of complete messages from one connection.

    :param transport: rospy's object for the connection
    :param topic: the subscribed topic, whose ``reads_until_empty`` is followed
    """

    def __init__(self, transport: TCPROSTransport, topic: Any) -> None:
        self._transport, self._topic = transport, topic
        self._data_class = transport.protocol.recv_data_class
        # One buffer for all reads: a new one for each recv() would fragment the heap. Pages of an
        # anonymous mapping that are never written take no memory.
        size = transport.protocol.buff_size
        self._buffer = memoryview(mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE))
        self._socket: Any = None
        # Beginning of an incomplete message, and its total length.
        self._parts: List[bytes] = []
        self._have = self._need = 0

    def receive_once(self) -> List[Any]:
        """Wait for messages. Replaces rospy's method of this name.

        :returns: all that have arrived, oldest first; empty if the connection is to end
        :raises TransportTerminated: if the publisher has closed the connection
        :raises TransportException: if there is no connection, or a message is malformed
        """
        transport = self._transport
        data = self._begin() if transport.socket is not self._socket else b""
        messages = self._unpack(data or self._read())
        while not messages and not transport.done and not rospy.core.is_shutdown():
            messages = self._unpack(self._read())
        if self._topic.reads_until_empty:
            self._read_until_empty(messages)
        transport.stat_num_msg += len(messages)
        if transport.is_latched and messages:
            transport.latch = messages[-1]
        return messages

    def _begin(self) -> bytes:
        """Start with a new connection; return the data that came with its header."""
        sock = self._transport.socket
        if sock is None:
            raise TransportInitError("connection not initialized")
        sock.setblocking(True)
        buffer = self._transport.read_buff
        data = bytes(buffer.getvalue()[: buffer.tell()])
        buffer.seek(0)
        buffer.truncate()
        self._socket = sock
        self._keep(b"")
        return data

    def _read(self) -> bytes:
        try:
            size = self._socket.recv_into(self._buffer)
        except OSError as error:
            raise TransportTerminated(f"unable to receive data from sender: {error}")
        if not size:
            raise TransportTerminated("the sender has closed the connection")
        self._transport.stat_bytes += size
        return bytes(self._buffer[:size])

    def _read_until_empty(self, messages: List[Any]) -> None:
        """Add the messages that have arrived meanwhile, without waiting.

        :param messages: those that are read already
        """
        deadline = time.monotonic() + _UNTIL_EMPTY_S
        with contextlib.suppress(OSError):  # nothing is left, or the next call reports the error
            while time.monotonic() < deadline:
                size = self._socket.recv_into(self._buffer, 0, socket.MSG_DONTWAIT)
                if not size:
                    return
                self._transport.stat_bytes += size
                messages += self._unpack(bytes(self._buffer[:size]))

    def _unpack(self, data: bytes) -> List[Any]:
        if self._parts:
            self._parts.append(data)
            self._have += len(data)
            if self._have < self._need:
                return []
            data = b"".join(self._parts)
        messages: List[Any] = []
        position, end = 0, len(data)
        header = self._transport.header
        while end - position >= _PREFIX:
            body = position + _PREFIX
            stop = body + _LENGTH.unpack_from(data, position)[0]
            if stop > end:
                break
            message = self._data_class()
            try:
                message.deserialize(data[body:stop])
            except genpy.DeserializationError as error:
                raise TransportException(f"cannot deserialize: {error}")
            message._connection_header = header
            messages.append(message)
            position = stop
        if position < end or self._parts:
            self._keep(data[position:])
        return messages

    def _keep(self, data: bytes) -> None:
        """Keep the beginning of a message until the rest arrives."""
        self._parts = [data] if data else []
        self._have = len(data)
        self._need = _PREFIX
        if len(data) >= _PREFIX:
            self._need += _LENGTH.unpack_from(data)[0]
