"""Channel between a publisher and a subscriber for descriptors of segments, and their return.

A subscriber's process listens on one local socket. The header of each connection tells publishers
the socket's name and a token of the connection. A publisher connects when it has a first large
message, sends the token, and each segment's descriptor before the first message in that segment.
The subscriber sends back the numbers of segments that it has read. The messages themselves are
announced on the topic's connection, see :mod:`.frame`.

Both ends belong to the same user, which the system verifies, see ``unix(7)``.
"""

import contextlib
import os
import socket
import struct
import threading
from typing import Dict, List, NamedTuple, Optional, Set

from nodekit.shared_memory.memory import ReadMemory

#: Field of the connection header; its value is :meth:`Offer.text`.
FIELD = "nodekit_shared_memory"
#: Longest wait for its token, which the publisher sends immediately [s].
_TOKEN_S = 0.5
_TOKEN_BYTES = 16
_NUMBER = struct.Struct("<I")
_CREDENTIALS = struct.Struct("3i")
_DESCRIPTOR = struct.Struct("i")
_BOOT_ID = "/proc/sys/kernel/random/boot_id"


class ChannelError(OSError):
    """Error of a channel: the other end has closed it or breaks the protocol."""


class Offer(NamedTuple):
    """Address at which a subscriber expects the channel of one connection."""

    #: identifies this start of this machine
    boot_id: str
    #: name of the subscriber's local socket
    name: str
    #: identifies the connection
    token: str

    def text(self) -> str:
        """Return the value of the header's field."""
        return " ".join(self)


def parse_offer(text: str) -> Optional[Offer]:
    """Return the offer in a header's field; None for a malformed one.

    :param text: value of the field
    """
    parts = text.split(" ")
    return Offer(*parts) if len(parts) == len(Offer._fields) and text.isprintable() else None


def boot_id() -> str:
    """Return the id of this machine's current boot; empty if unknown."""
    try:
        with open(_BOOT_ID) as file:
            return file.read().strip()
    except OSError:
        return ""


def _is_of_this_user(sock: socket.socket) -> bool:
    """Return whether a socket's other end belongs to this process's user."""
    data = sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    user: int = _CREDENTIALS.unpack(data)[1]
    return user == os.geteuid()


class OfferRejected(Exception):
    """Error of an offer that cannot be used; the text has the reason."""


class WriterChannel:
    """A publisher's end of the channel to one subscriber.

    :param offer: the subscriber's offer
    :raises OfferRejected: if the subscriber is on another host, belongs to another user, or cannot
        be reached
    """

    def __init__(self, offer: Offer) -> None:
        if not offer.boot_id or offer.boot_id != boot_id():
            raise OfferRejected("the subscriber is on another host")
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            self._socket.setblocking(False)
            self._socket.connect("\0" + offer.name)
            if not _is_of_this_user(self._socket):
                raise OfferRejected("the subscriber belongs to another user")
            self._socket.send(offer.token.encode())
        except OSError as error:
            self._socket.close()
            raise OfferRejected(f"its local socket cannot be reached: {error}") from None
        except OfferRejected:
            self._socket.close()
            raise
        #: segments that the subscriber has, and those of them that hold an announced message
        self.known: Set[int] = set()
        self.in_flight: Set[int] = set()
        self._retired: List[int] = []

    def fileno(self) -> int:
        """Return the socket's descriptor, -1 for a closed socket."""
        return self._socket.fileno()

    def announce(self, number: int, descriptor: int) -> None:
        """Make sure that the subscriber has a segment, which it will give back.

        :param number: the segment's number
        :param descriptor: its memory
        :raises OSError: if the subscriber is gone, or its socket is full
        """
        while self._retired:
            self._socket.send(_NUMBER.pack(self._retired[0]))
            del self._retired[0]
        if number not in self.known:
            rights = (socket.SOL_SOCKET, socket.SCM_RIGHTS, _DESCRIPTOR.pack(descriptor))
            self._socket.sendmsg([_NUMBER.pack(number)], [rights])
            self.known.add(number)
        self.in_flight.add(number)

    def retire(self, number: int) -> None:
        """Notify the subscriber, now or later, that a segment is no longer used.

        :param number: the segment's number
        """
        if number in self.known:
            self.known.discard(number)
            self._retired.append(number)
            with contextlib.suppress(OSError):  # sent before the next announcement
                self._socket.send(_NUMBER.pack(number))
                self._retired.remove(number)

    def returned(self) -> List[int]:
        """Return the segments that the subscriber has given back since the last call.

        :raises ChannelError: if the subscriber is gone
        """
        numbers: List[int] = []
        while True:
            try:
                data = self._socket.recv(_NUMBER.size)
            except BlockingIOError:
                return numbers
            except OSError as error:
                raise ChannelError(str(error)) from None
            if len(data) != _NUMBER.size:
                raise ChannelError("the subscriber is gone")
            (number,) = _NUMBER.unpack(data)
            self.in_flight.discard(number)
            numbers.append(number)
        return numbers

    def close(self) -> None:
        """Close the channel."""
        self._socket.close()


class Loan:
    """Segment with a message that its reader has not given back; given back with this object.

    :param channel: the reader's end of the channel
    :param number: the segment's number
    """

    __slots__ = ("_channel", "_number")

    def __init__(self, channel: "ReaderChannel", number: int) -> None:
        self._channel, self._number = channel, number

    def __del__(self) -> None:
        self._channel.give_back(self._number)


class ReaderChannel:
    """A subscriber's end of the channel; it ends with the last loan.

    :param sock: connected socket
    """

    def __init__(self, sock: socket.socket) -> None:
        self._socket = sock
        sock.setblocking(False)
        self._process = os.getpid()
        self._memories: Dict[int, ReadMemory] = {}

    def __del__(self) -> None:
        self._socket.close()

    def memory(self, number: int) -> ReadMemory:
        """Return a segment that a message was announced in.

        :param number: the segment's number
        :raises OSError: if it was not sent, or cannot be mapped
        """
        self.update()
        memory = self._memories.get(number)
        if memory is None:
            raise ChannelError(f"segment {number} was not sent")
        return memory

    def update(self) -> None:
        """Map the segments that have been sent, and drop segments that are no longer used.

        :raises OSError: if one cannot be mapped
        """
        while True:
            try:
                data, rights, _, _ = self._socket.recvmsg(
                    _NUMBER.size, socket.CMSG_SPACE(_DESCRIPTOR.size), socket.MSG_CMSG_CLOEXEC
                )
            except BlockingIOError:
                return
            except ConnectionResetError:  # raised once, before the data sent until the end
                continue
            if len(data) != _NUMBER.size:
                return  # closed; what was sent before is complete
            (number,) = _NUMBER.unpack(data)
            self._memories.pop(number, None)
            for level, kind, content in rights:
                if (level, kind) == (socket.SOL_SOCKET, socket.SCM_RIGHTS):
                    (descriptor,) = _DESCRIPTOR.unpack(content)
                    try:
                        self._memories[number] = ReadMemory(descriptor)
                    finally:
                        os.close(descriptor)

    def give_back(self, number: int) -> None:
        """Notify the publisher that a message is read. From any thread, without waiting.

        A forked child has copies of the loans, and ends none.

        :param number: the segment's number
        """
        if os.getpid() != self._process:
            return
        with contextlib.suppress(OSError):  # the publisher is gone
            self._socket.send(_NUMBER.pack(number))


class ChannelListener:
    """Local socket of this process, on which publishers open channels.

    :raises OSError: if there is no descriptor left
    """

    def __init__(self) -> None:
        self._boot_id = boot_id()
        self._name = "nodekit-" + os.urandom(_TOKEN_BYTES).hex()
        self._lock = threading.Lock()
        self._arrived: Dict[str, socket.socket] = {}
        #: tokens of the connections that exist
        self._expected: Set[str] = set()
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            self._socket.bind("\0" + self._name)
            self._socket.listen(128)
            self._socket.setblocking(False)
        except BaseException:
            self._socket.close()
            raise

    def offer(self) -> Offer:
        """Return a new connection's offer; end it by :meth:`withdraw`."""
        token = os.urandom(_TOKEN_BYTES).hex()
        with self._lock:
            self._expected.add(token)
        return Offer(self._boot_id, self._name, token)

    def take(self, offer: Offer) -> ReaderChannel:
        """Return the channel that a publisher has opened for a connection.

        :param offer: the connection's offer
        :raises OSError: if no publisher has opened it
        """
        with self._lock:
            self._accept_all()  # a publisher opens its channel before it announces a message
            sock = self._arrived.pop(offer.token, None)
        if sock is None:
            raise ChannelError("the publisher has not opened its channel")
        return ReaderChannel(sock)

    def _accept_all(self) -> None:
        """Accept the channels that wait; without descriptors left, later."""
        with contextlib.suppress(OSError):
            while True:
                self._keep(self._socket.accept()[0])

    def _keep(self, sock: socket.socket) -> None:
        """Keep a channel; close it if its user is another, or its connection has ended."""
        token = ""
        with contextlib.suppress(OSError, UnicodeDecodeError):
            sock.settimeout(_TOKEN_S)
            if _is_of_this_user(sock):
                token = sock.recv(2 * _TOKEN_BYTES).decode()
        if token in self._expected and token not in self._arrived:
            self._arrived[token] = sock
        else:
            sock.close()

    def withdraw(self, offer: Offer) -> None:
        """End the offer of a connection that has ended.

        :param offer: the offer
        """
        with self._lock:
            self._accept_all()
            self._expected.discard(offer.token)
            arrived = self._arrived.pop(offer.token, None)
        if arrived is not None:
            arrived.close()
