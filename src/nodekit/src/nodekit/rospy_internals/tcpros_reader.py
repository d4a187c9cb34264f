"""How rospy reads from a publisher's connection: what one read brings is unpacked at once."""

import mmap
import struct
from typing import Any, List

import genpy
import rospy.core
from rospy.exceptions import TransportException, TransportInitError, TransportTerminated
from rospy.impl.tcpros_base import TCPROSTransport

_LENGTH = struct.Struct("<I")
_PREFIX = _LENGTH.size


class Reader:
    """Reads whole messages from one connection.

    :param transport: rospy's object for it
    """

    def __init__(self, transport: TCPROSTransport) -> None:
        self._transport = transport
        self._data_class = transport.protocol.recv_data_class
        # Read into, again and again, and copied out of: what recv() makes for each read, it gives
        # back in pieces, between which the memory of threads tears and grows. Of the pages of this,
        # only those that are read into are taken.
        size = transport.protocol.buff_size
        self._buffer = memoryview(mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE))
        self._socket: Any = None
        # The beginning of a message that has not arrived as a whole, and its whole length.
        self._parts: List[bytes] = []
        self._have = self._need = 0

    def receive_once(self) -> List[Any]:
        """Wait for messages. Stands in for rospy's method of this name.

        :returns: all that have arrived, oldest first; none if the connection is to end
        :raises TransportTerminated: if the publisher is gone
        :raises TransportException: if there is no connection, or it brings nonsense
        """
        transport = self._transport
        data = self._begin() if transport.socket is not self._socket else b""
        messages = self._unpack(data or self._read())
        while not messages and not transport.done and not rospy.core.is_shutdown():
            messages = self._unpack(self._read())
        transport.stat_num_msg += len(messages)
        if transport.is_latched and messages:
            transport.latch = messages[-1]
        return messages

    def _begin(self) -> bytes:
        """Begin with a new connection; return what came together with its header."""
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
        """Keep the beginning of a message until the rest is there."""
        self._parts = [data] if data else []
        self._have = len(data)
        self._need = _PREFIX
        if len(data) >= _PREFIX:
            self._need += _LENGTH.unpack_from(data)[0]
