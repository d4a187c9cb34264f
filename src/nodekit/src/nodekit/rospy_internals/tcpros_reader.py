"""Reader of a publisher's connection; unpacks all messages of one read together.

Large messages may be announced there, and read from shared memory.
"""

import contextlib
import mmap
import socket
import struct
import time
from typing import Any, Dict, List, Optional

import genpy
import rospy.core
from rospy.exceptions import TransportException, TransportInitError, TransportTerminated
from rospy.impl.tcpros_base import TCPROSTransport

from nodekit.rospy_internals import shared_memory_offers
from nodekit.rospy_internals.large_arrays import byte_fields, fill, without_views
from nodekit.shared_memory import frame
from nodekit.shared_memory.channel import FIELD, Loan, ReaderChannel

_LENGTH = struct.Struct("<I")
_PREFIX = _LENGTH.size
#: Longest time to continue reading after a message, for callbacks that want the newest [s].
_UNTIL_EMPTY_S = 0.05
#: Time between two checks for unused memory while no message arrives: a ``timeval``.
_CHECK_EVERY = struct.pack("ll", 5, 0)


class Reader:
    """Reader of complete messages from one connection.

    :param transport: rospy's object for the connection
    :param topic: the subscribed topic; ``reads_until_empty`` and ``takes_views`` are its settings
    """

    def __init__(self, transport: TCPROSTransport, topic: Any) -> None:
        self._transport, self._topic = transport, topic
        self._data_class = transport.protocol.recv_data_class
        # One buffer for all reads: a new one for each recv() would fragment the heap. Pages of an
        # anonymous mapping that are never written take no memory.
        size = transport.protocol.buff_size
        self._buffer = memoryview(mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE))
        self._socket: Any = None
        #: The offered channel for shared memory, and whether it is used.
        self._channel: Optional[ReaderChannel] = None
        self._is_shared = False
        #: Whether shared memory is offered: not after it failed, for lack of descriptors or memory.
        self._offers = True
        #: Number of messages to this subscriber that the publisher has lost, from the latest
        #: announcement; -1 before the first one.
        self.lost = -1
        fields = transport.protocol.get_header_fields
        transport.protocol.get_header_fields = lambda: {**fields(), **self._offered()}
        # Beginning of an incomplete message, and its total length.
        self._parts: List[bytes] = []
        self._have = self._need = 0

    def _offered(self) -> Dict[str, str]:
        """Return the header field that offers shared memory on a new connection, if possible."""
        self._is_shared = False
        shared_memory_offers.name_transport(self._transport, is_shared=False)
        self._channel = None
        if self._offers:
            self._channel = shared_memory_offers.new_channel(self._data_class)
        return {} if self._channel is None else {FIELD: self._channel.name}

    def close(self) -> None:
        """End the channel, once the last message in shared memory is read. From any thread."""
        self._channel = None

    def receive_once(self) -> List[Any]:
        """Wait for messages. Replaces rospy's method of this name.

        :returns: all that have arrived, oldest first; empty if the connection is to end
        :raises TransportTerminated: if the publisher has closed the connection
        :raises TransportException: if there is no connection, or a message is malformed
        """
        try:
            return self._receive()
        except TransportException:
            self.close()
            raise

    def _receive(self) -> List[Any]:
        transport = self._transport
        data = self._begin() if transport.socket is not self._socket else b""
        messages = self._unpack(data or self._read())
        while not messages and not transport.done and not rospy.core.is_shutdown():
            messages = self._unpack(self._read())
        if self._topic.reads_until_empty:
            self._read_until_empty(messages)
        transport.stat_num_msg += len(messages)
        if transport.is_latched and messages:
            transport.latch = without_views(messages[-1])
        return messages

    def _begin(self) -> bytes:
        """Start with a new connection; return the data received with its header."""
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
            size = self._receive_into()
        except OSError as error:
            raise TransportTerminated(f"unable to receive data from sender: {error}")
        if not size:
            raise TransportTerminated("the sender has closed the connection")
        self._transport.stat_bytes += size
        return bytes(self._buffer[:size])

    def _receive_into(self) -> int:
        """Wait for data; with a channel, also drop the memory of read messages."""
        while True:
            try:
                return int(self._socket.recv_into(self._buffer))
            except BlockingIOError:  # only with the socket's time-out
                channel = self._channel
                if channel is not None:
                    channel.forget()

    def _read_until_empty(self, messages: List[Any]) -> None:
        """Add the messages that have arrived meanwhile, without waiting.

        :param messages: the messages read so far
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
            size = _LENGTH.unpack_from(data, position)[0]
            body = position + _PREFIX
            stop = body + size if size != frame.MARK else position + frame.SIZE
            if stop > end:
                break
            message = self._data_class()
            try:
                if size != frame.MARK:
                    message.deserialize(data[body:stop])
                else:
                    self._read_shared(message, frame.unpack_from(data, position))
            except OSError as error:
                self._offers = False
                raise TransportException(f"cannot read shared memory: {error}")
            except (genpy.DeserializationError, ValueError) as error:
                raise TransportException(f"cannot deserialize: {error}")
            message._connection_header = header
            messages.append(message)
            position = stop
        if position < end or self._parts:
            self._keep(data[position:])
        return messages

    def _read_shared(self, message: Any, announced: frame.Frame) -> None:
        """Read a message from shared memory.

        :param message: the message to be filled
        :param announced: its announcement
        :raises OSError: if the publisher has not sent the segment
        :raises ValueError: if the message does not lie in it
        :raises genpy.DeserializationError: if the message is malformed
        """
        channel = self._channel
        if channel is None:
            raise ValueError("a message in shared memory, which was not offered")
        memory = channel.receive(announced.segment)
        if not self._is_shared:
            self._begin_to_share()
        loan = Loan(channel, announced.segment)
        if announced.size > memory.size:
            raise ValueError(f"announced beyond its segment of {memory.size} bytes: {announced}")
        self._transport.stat_bytes += announced.size
        self.lost = announced.lost
        if announced.field not in byte_fields(self._data_class):
            content = memory.read(0, announced.size)
            del loan
            message.deserialize(content)
            return
        head = memory.read(0, announced.start)
        tail = memory.read(announced.stop, announced.size)
        if self._topic.takes_views:
            array: Any = memory.view(announced.start, announced.stop, loan)
        else:
            array = memory.read(announced.start, announced.stop)
        del loan  # without a view, the publisher may write there from now on
        fill(message, head, tail, announced.field, array)

    def _begin_to_share(self) -> None:
        self._is_shared = True
        # Wakes the thread up, to release memory.
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, _CHECK_EVERY)
        shared_memory_offers.name_transport(self._transport)

    def _keep(self, data: bytes) -> None:
        """Keep the beginning of a message until the rest arrives."""
        self._parts = [data] if data else []
        self._have = len(data)
        self._need = _PREFIX
        if len(data) >= _PREFIX:
            size = _LENGTH.unpack_from(data)[0]
            self._need = frame.SIZE if size == frame.MARK else _PREFIX + size
