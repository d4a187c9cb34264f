# Pure: knows no ROS.
"""Channel between a publisher and a subscriber for descriptors of segments, and their return.

The subscriber's end is a local socket, whose name is in the header of its connection. A publisher
connects when it has a first large message. It sends the number and the descriptor of the segment of
each message, with the numbers of its other segments; the subscriber sends the number back when it
has read the message. The messages themselves are announced on the topic's connection, see
:mod:`.frame`.

Both ends belong to the same user, which the system verifies, see ``unix(7)``.
"""

import contextlib
import os
import socket
import struct
from typing import Dict, List

from nodekit.shared_memory.memory import ReadMemory
from nodekit.shared_memory.segment_pool import Segment

#: Field of the connection header; its value is :attr:`ReaderChannel.name`.
FIELD = "nodekit_shared_memory"
#: Beginning of all sockets' names: a header cannot name another program's socket.
_PREFIX = "\0nodekit-"
_NUMBER = struct.Struct("<I")
_CREDENTIALS = struct.Struct("3i")
_DESCRIPTOR = struct.Struct("i")
#: Longest list of segments [bytes]: more than a pool can have.
_MOST_NUMBERS = 1024 * _NUMBER.size


class ChannelError(OSError):
    """Error of a channel: the other end has closed it, or breaks the protocol."""


def _new_socket() -> socket.socket:
    return socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)


def _is_of_this_user(sock: socket.socket) -> bool:
    """Return whether a socket's other end belongs to this process's user."""
    data = sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    user: int = _CREDENTIALS.unpack(data)[1]
    return user == os.geteuid()


class WriterChannel:
    """A publisher's end of the channel to one subscriber.

    :param name: the name in the subscriber's header
    :raises OSError: if the subscriber is on another machine, belongs to another user, or cannot be
        reached
    """

    def __init__(self, name: str) -> None:
        #: segments with announced messages that the subscriber has not given back, by number
        self.in_flight: Dict[int, Segment] = {}
        self._socket = _new_socket()
        try:
            self._socket.setblocking(False)
            self._socket.connect(_PREFIX + name)
            if not _is_of_this_user(self._socket):
                raise ChannelError("the subscriber belongs to another user")
        except BaseException:
            self._socket.close()
            raise

    def fileno(self) -> int:
        """Return the socket's descriptor, -1 for a closed socket."""
        return self._socket.fileno()

    def announce(self, segment: Segment, numbers: List[int]) -> None:
        """Send a segment to the subscriber, which will give it back.

        :param segment: the segment
        :param numbers: the numbers of all segments
        :raises OSError: if the subscriber is gone
        """
        data = b"".join(map(_NUMBER.pack, [segment.number, *numbers]))
        rights = _DESCRIPTOR.pack(segment.memory.descriptor)
        self._socket.sendmsg([data], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, rights)])
        segment.users += 1
        self.in_flight[segment.number] = segment

    def collect(self) -> bool:
        """Release the segments that the subscriber has given back, all of them if it is gone.

        :returns: whether the subscriber is there; otherwise the channel is closed
        """
        with contextlib.suppress(OSError):
            while True:
                try:
                    data = self._socket.recv(_NUMBER.size)
                except BlockingIOError:
                    return True
                if len(data) != _NUMBER.size:
                    break
                segment = self.in_flight.pop(_NUMBER.unpack(data)[0], None)
                if segment is not None:
                    segment.users -= 1
        self.close()
        return False

    def close(self) -> None:
        """Close the channel, and release all segments."""
        self._socket.close()
        while self.in_flight:
            self.in_flight.popitem()[1].users -= 1


class ReaderChannel:
    """A subscriber's end of the channel; it ends with the last loan.

    :raises OSError: if there is no descriptor left
    """

    def __init__(self) -> None:
        self.name = os.urandom(16).hex()
        self._process = os.getpid()
        self._memories: Dict[int, ReadMemory] = {}
        self._is_connected = False
        self._socket = _new_socket()
        self._socket.bind(_PREFIX + self.name)
        self._socket.listen(8)
        self._socket.setblocking(False)

    def __del__(self) -> None:
        with contextlib.suppress(AttributeError):  # there was no descriptor
            self._socket.close()

    def receive(self, number: int) -> ReadMemory:
        """Return the segment of the next message.

        :param number: the segment's number in the message's announcement
        :raises OSError: if it was not sent, or cannot be mapped
        """
        if not self._is_connected:
            self._accept()
        space = socket.CMSG_SPACE(_DESCRIPTOR.size)
        arguments = (_MOST_NUMBERS, space, socket.MSG_CMSG_CLOEXEC)
        try:
            data, rights, _, _ = self._socket.recvmsg(*arguments)
        except ConnectionResetError:  # raised once, before the data sent until the end
            data, rights, _, _ = self._socket.recvmsg(*arguments)
        descriptors = [_DESCRIPTOR.unpack(content)[0] for _, _, content in rights]
        try:
            sent, *numbers = struct.unpack_from(f"<{len(data) // _NUMBER.size}I", data) or (0,)
            for old in set(self._memories).difference(numbers):
                del self._memories[old]
            if sent != number:
                raise ChannelError(f"segment {number} was announced, and {sent} sent")
            if number not in self._memories:
                if not descriptors:
                    raise ChannelError(f"segment {number} was sent without memory")
                self._memories[number] = ReadMemory(descriptors[0])
            return self._memories[number]
        finally:
            for descriptor in descriptors:
                os.close(descriptor)

    def _accept(self) -> None:
        """Accept the publisher's connection, which it opens before it announces a message."""
        while not self._is_connected:
            sock, _ = self._socket.accept()
            if _is_of_this_user(sock):
                self._socket.close()
                self._socket, self._is_connected = sock, True
                sock.setblocking(False)
            else:
                sock.close()

    def forget(self) -> None:
        """Drop the memory of read messages; it is sent again with the next ones."""
        self._memories.clear()

    def give_back(self, number: int) -> None:
        """Notify the publisher that a message is read. From any thread, without waiting.

        A forked child has copies of the loans, and ends none.

        :param number: the segment's number
        """
        if os.getpid() == self._process:
            with contextlib.suppress(OSError):  # the publisher is gone
                self._socket.send(_NUMBER.pack(number))


class Loan:
    """Segment on loan to a subscriber, which gives it back when this object is deleted.

    :param channel: the reader's end of the channel
    :param number: the segment's number
    """

    __slots__ = ("_channel", "_number")

    def __init__(self, channel: ReaderChannel, number: int) -> None:
        self._channel, self._number = channel, number

    def __del__(self) -> None:
        self._channel.give_back(self._number)
