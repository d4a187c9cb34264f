"""Call of a ROS service over TCP, with a deadline.

The protocol is TCPROS as http://wiki.ros.org/ROS/TCPROS and
http://wiki.ros.org/ROS/Connection%20Header describe it: each side sends a header, a list of
``name=value``; then the client sends a request, and the server a byte that is 1 on success, and its
response or an error text. Every length has 4 bytes, little-endian.
"""

import contextlib
import socket
import struct
import threading
import time
from typing import Dict, Optional, Tuple

_LENGTH = struct.Struct("<I")
#: Longest accepted header [bytes].
_LONGEST_HEADER = 64 * 1024


class CallFailed(Exception):
    """Error response of the server; the text gives the reason."""


class ServiceCall:
    """Call that can be cancelled at any moment, from any thread.

    :param timeout: longest time from now to the response [s]

    :ivar deadline: end of that time on the monotonic clock [s]
    :ivar said: the server's header, once received: ``type`` and other fields
    """

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        self.deadline = time.monotonic() + timeout
        self._lock = threading.Lock()
        self._socket: Optional[socket.socket] = None
        self._is_cancelled = False
        self.said: Dict[str, str] = {}

    def run(
        self, address: Tuple[str, int], header: Dict[str, str], request: Optional[bytes]
    ) -> bytes:
        """Call the service.

        :param address: host and port
        :param header: connection header of the client
        :param request: serialized request; None for the handshake only
        :returns: the serialized response
        :raises CallFailed: if the server rejects the header, or replies with an error
        :raises socket.timeout: if the deadline has passed
        :raises OSError: if the connection fails, or the call is cancelled
        """
        with contextlib.closing(socket.create_connection(address, self.left())) as connection:
            with self._lock:
                if self._is_cancelled:
                    raise OSError("cancelled")
                self._socket = connection
            try:
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._send(_encoded(header))
                self.said = self._read_header()
                if "error" in self.said:
                    raise CallFailed(self.said["error"])
                if request is None:
                    return b""
                self._send(request)
                is_good = self._receive(1) == b"\1"
                body = self._receive(*_LENGTH.unpack(self._receive(_LENGTH.size)))
                if not is_good:
                    raise CallFailed(body.decode(errors="replace"))
                return body
            finally:
                with self._lock:  # cancel() must not use a descriptor that has been reused
                    self._socket = None

    def cancel(self) -> None:
        """Cancel the call; its pending operation fails."""
        with self._lock:
            self._is_cancelled = True
            if self._socket is not None:
                with contextlib.suppress(OSError):  # the server has just disconnected
                    self._socket.shutdown(socket.SHUT_RDWR)

    def left(self) -> float:
        """Return the time left for the call [s].

        :raises socket.timeout: if the deadline has passed
        """
        left = self.deadline - time.monotonic()
        if left <= 0.0:
            raise socket.timeout("timed out")
        return left

    def _send(self, content: bytes) -> None:
        assert self._socket is not None
        self._socket.settimeout(self.left())
        self._socket.sendall(_LENGTH.pack(len(content)) + content)

    def _receive(self, size: int) -> bytes:
        assert self._socket is not None
        parts = []
        while size:
            self._socket.settimeout(self.left())
            part = self._socket.recv(min(size, 1 << 20))
            if not part:
                raise ConnectionError("the server hung up")
            parts.append(part)
            size -= len(part)
        return b"".join(parts)

    def _read_header(self) -> Dict[str, str]:
        (size,) = _LENGTH.unpack(self._receive(_LENGTH.size))
        if size > _LONGEST_HEADER:
            raise CallFailed(f"it announces a header of {size} bytes: not a ROS service")
        content, fields = self._receive(size), {}
        while content:
            (length,) = _LENGTH.unpack(content[: _LENGTH.size].ljust(_LENGTH.size, b"\0"))
            field, content = content[_LENGTH.size :][:length], content[_LENGTH.size + length :]
            name, _, value = field.decode(errors="replace").partition("=")
            fields[name] = value
        return fields


def _encoded(header: Dict[str, str]) -> bytes:
    lines = [f"{name}={value}".encode() for name, value in header.items()]
    return b"".join(_LENGTH.pack(len(line)) + line for line in lines)
