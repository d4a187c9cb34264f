"""TCPROS server that no silent connection can block.

rospy reads the header of each connection before it accepts the next one, so that a silent client
blocks all others. The server here reads the available part of each header without waiting, passes
a complete header to rospy's handlers, and closes connections that take too long.
"""

import contextlib
import errno
import selectors
import socket
import struct
import time
from typing import Any, Dict, Optional, Tuple

import rospy
import rospy.core
from rosgraph.network import decode_ros_handshake_header, write_ros_handshake_header
from rospy.exceptions import TransportInitError
from rospy.impl.tcpros_base import TCPROSServer, TCPServer

from nodekit.rospy_internals import shared_memory_offers

#: Timeout from a connection to the end of its header [s].
HEADER_TIMEOUT_S = 10.0
#: Most connections with incomplete headers. At this limit, no connection is accepted until the
#: oldest is closed.
MOST_WAITING = 100
#: Timeout of a header at that limit [s]: a process that connects to hundreds of topics
#: sends its headers a little later.
GRACE_S = 1.0
#: Longest header [bytes]. The message definition, its longest part, has a few thousand.
LONGEST_HEADER = 1_000_000

#: Timeout for sending a rejection [s].
_ANSWER_S = 0.1
#: Pause after a failed accept(), as without a free descriptor [s].
_PAUSE_S = 0.5
#: Longest logged reason [characters]: rospy's reasons hold all topics, and the whole header.
_LONGEST_REASON = 500
#: Errors that accept() raises on a closed socket. Others concern one connection, or are temporary;
#: see accept(2).
_CLOSED = (errno.EBADF, errno.EINVAL, errno.ENOTSOCK)

_LENGTH = struct.Struct("<I")
#: rospy's own methods, and the names that known versions use in them.
_RUN, _START = TCPServer.run, TCPROSServer.start_server
_HANDLE = getattr(TCPROSServer, "_tcp_server_callback", None)
_RUN_USES = {"is_shutdown", "server_sock", "accept", "inbound_handler"}
_HANDLE_USES = {
    "read_ros_handshake_header",
    "write_ros_handshake_header",
    "topic_connection_handler",
    "service_connection_handler",
}
_START_USES = {"TCPServer", "_tcp_server_callback"}


def tcpros_server_mismatch() -> str:
    """Compare rospy's server with the expectations of this module.

    :returns: the first difference; empty without one
    """
    for method, names in ((_RUN, _RUN_USES), (_START, _START_USES), (_HANDLE, _HANDLE_USES)):
        code = getattr(method, "__code__", None)
        missing = names.difference(code.co_names if code is not None else ())
        if missing:
            name = getattr(method, "__qualname__", method)
            return f"{name} does not use {', '.join(sorted(missing))}"
    return ""


def patch_tcpros_server() -> None:
    """Replace the accept loop of servers that are started from now on."""
    mismatch = tcpros_server_mismatch()
    if mismatch:
        rospy.logwarn("unsupported rospy version: a silent connection delays others: %s", mismatch)
    else:
        TCPServer.run = lambda server: _Acceptor(server).run()


class _Pending:
    """Connection whose header is incomplete.

    :param sock: its socket
    :param address: address of the client
    """

    def __init__(self, sock: socket.socket, address: Tuple[Any, ...]) -> None:
        self.socket = sock
        self.address = address
        self.since = time.monotonic()
        self._data = bytearray()
        sock.setblocking(False)

    def read_header(self) -> Optional[Dict[str, str]]:
        """Read the available part of the header, and nothing that follows it.

        :returns: the header; None while it is incomplete
        :raises Exception: if the header is invalid, or the connection is closed
        """
        need = _LENGTH.size
        while True:
            while len(self._data) < need:
                try:
                    data = self.socket.recv(need - len(self._data))
                except BlockingIOError:
                    return None
                if not data:
                    raise TransportInitError("it ended before its header was complete")
                self._data += data
            (size,) = _LENGTH.unpack_from(self._data)
            if size > LONGEST_HEADER:
                raise TransportInitError(
                    f"its header of {size} bytes is longer than the limit of {LONGEST_HEADER}"
                )
            if need == _LENGTH.size + size:
                header: Dict[str, str] = decode_ros_handshake_header(bytes(self._data))
                return header
            need += size


class _Acceptor:
    """Accept loop of a server.

    :param server: rospy's object, which listens
    """

    def __init__(self, server: TCPServer) -> None:
        self._server = server
        self._selector = selectors.DefaultSelector()
        self._listens = False
        #: Connections with incomplete headers, the oldest first.
        self._pending: Dict[Any, _Pending] = {}

    def run(self) -> None:
        """Accept connections until the server is shut down."""
        try:
            self._run(self._server.server_sock)
        except (OSError, ValueError):  # ValueError for a socket that has just been closed
            if not self._server.is_shutdown:
                raise
        finally:
            for pending in self._pending.values():
                pending.socket.close()
            self._selector.close()

    def _run(self, listener: socket.socket) -> None:
        listener.setblocking(False)
        # rospy's backlog is 5; clients beyond that would retry after 1 s.
        listener.listen(MOST_WAITING)
        while not self._server.is_shutdown:
            self._listen(listener, len(self._pending) < MOST_WAITING)
            ready = {key.fileobj for key, _ in self._selector.select(self._time_left())}
            # In the order of arrival: of two connections of one node, rospy keeps the later.
            for pending in list(self._pending.values()):
                if pending.socket in ready:
                    self._read_from(pending)
            if listener in ready:
                self._accept(listener)
            self._drop_expired()

    def _listen(self, listener: socket.socket, listens: bool) -> None:
        if listens and not self._listens:
            self._selector.register(listener, selectors.EVENT_READ)
        elif self._listens and not listens:
            self._selector.unregister(listener)
        self._listens = listens

    def _time_left(self) -> Optional[float]:
        """Return the time left for the oldest connection [s]; None without connections."""
        patience = GRACE_S if len(self._pending) >= MOST_WAITING else HEADER_TIMEOUT_S
        for pending in self._pending.values():
            return pending.since + patience - time.monotonic()
        return None

    def _accept(self, listener: socket.socket) -> None:
        try:
            sock, address = listener.accept()
        except (BlockingIOError, ConnectionAbortedError):
            return
        except OSError as error:
            if error.errno in _CLOSED:
                raise
            rospy.logwarn("cannot accept a connection: %s", error)
            time.sleep(_PAUSE_S)
            return
        pending = self._pending[sock] = _Pending(sock, address)
        self._selector.register(sock, selectors.EVENT_READ)
        self._read_from(pending)

    def _read_from(self, pending: _Pending) -> None:
        """Read from a connection; pass it on when its header is complete."""
        try:
            header = pending.read_header()
            if header is None:
                return
            self._forget(pending)
            self._hand_over(pending, header)
        except Exception as error:  # of any kind: the handlers do not check the header
            self._close(pending, error)

    def _hand_over(self, pending: _Pending, header: Dict[str, str]) -> None:
        """Pass a connection to rospy's handlers.

        :raises TransportInitError: if they reject it
        """
        handlers = self._server.inbound_handler.__self__
        error = "no topic or service name detected"
        pending.socket.setblocking(True)
        if "topic" in header:
            shared_memory_offers.remember(pending.socket, header)
            error = handlers.topic_connection_handler(pending.socket, pending.address, header)
        elif "service" in header:
            error = handlers.service_connection_handler(pending.socket, pending.address, header)
        if error:
            pending.socket.settimeout(_ANSWER_S)
            with contextlib.suppress(OSError):
                write_ros_handshake_header(pending.socket, {"error": error})
            raise TransportInitError(f"{error} {header}")

    def _drop_expired(self) -> None:
        """Close connections after their timeout."""
        for pending in list(self._pending.values()):
            left = self._time_left()
            if left is None or left > 0.0:
                break
            waited = time.monotonic() - pending.since
            self._close(pending, f"it sent no complete header within {waited:.1f} s")

    def _close(self, pending: _Pending, why: object) -> None:
        self._forget(pending)
        pending.socket.close()
        if not rospy.core.is_shutdown_requested():
            reason = str(why)[:_LONGEST_REASON]
            rospy.logwarn("closed a connection from %s: %s", pending.address[0], reason)

    def _forget(self, pending: _Pending) -> None:
        if self._pending.pop(pending.socket, None) is not None:
            self._selector.unregister(pending.socket)
