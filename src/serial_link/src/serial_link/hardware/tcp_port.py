"""TCP port to which boards with Wi-Fi connect."""

import contextlib
import select
import socket
from typing import Optional

from serial_link.hardware.ports import PortLost, PortStuck, PortUnavailable

_WRITE_S = 0.5
_READ_AT_ONCE = 4096
#: TCP sends again what is lost on the way: a pause may be long [s], and nothing is damaged.
_GAP_S = 5.0


class TcpPort:
    """Listens for one board; a new connection replaces the one before.

    A board that was reset leaves an open connection behind, and connects again.

    :param address: where to listen: ``localhost``, or an address that others reach too
    :param number: TCP port
    """

    baud, gap = 0, _GAP_S

    def __init__(self, address: str, number: int) -> None:
        self._address = (address, number)
        self._own_name = self.name = f"tcp {address}:{number}"
        self._listener: Optional[socket.socket] = None
        self._board: Optional[socket.socket] = None

    def open(self, timeout: float) -> bool:
        """Wait for a board; see :class:`.Port`."""
        listener = self._listener or self._listen()
        if not select.select([listener], [], [], timeout)[0]:
            return False
        try:
            board, peer = listener.accept()
        except OSError:  # it has gone already
            return False
        board.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        board.settimeout(_WRITE_S)
        self._board = board
        self.name = f"{self._own_name} from {peer[0]}:{peer[1]}"
        return True

    def read(self, timeout: float) -> bytes:
        """Return what has arrived; see :class:`.Port`."""
        board, listener = self._connected(), self._listener
        assert listener is not None
        try:
            ready = select.select([board, listener], [], [], timeout)[0]
            if listener in ready:
                raise PortLost(f"{self.name}: another board has connected")
            if not ready:
                return b""
            data = board.recv(_READ_AT_ONCE)
        except PortLost:
            raise
        except (OSError, ValueError) as error:
            raise PortLost(f"{self.name} is gone: {error}") from None
        if not data:
            raise PortLost(f"{self.name}: the connection was closed")
        return data

    def write(self, data: bytes) -> None:
        """Send bytes; see :class:`.Port`.

        Where part of a message is sent, the connection ends: the next would be taken for the rest.
        """
        board = self._connected()
        try:
            if not select.select([], [board], [], _WRITE_S)[1]:
                raise PortStuck(f"{self.name} takes nothing for {_WRITE_S:g} s")
            board.sendall(data)
        except PortStuck:
            raise
        except socket.timeout:
            with contextlib.suppress(OSError):  # it is gone already
                board.shutdown(socket.SHUT_RDWR)  # which the thread that reads is told
            raise PortStuck(f"{self.name} takes no more of a message for {_WRITE_S:g} s") from None
        except (OSError, ValueError) as error:
            raise PortLost(f"{self.name} is gone: {error}") from None

    def close(self) -> None:
        """Close the board's connection; go on listening."""
        board, self._board = self._board, None
        self.name = self._own_name
        if board is not None:
            board.close()

    def release(self) -> None:
        """Listen no longer."""
        self.close()
        listener, self._listener = self._listener, None
        if listener is not None:
            listener.close()

    def _connected(self) -> socket.socket:
        board = self._board
        if board is None:
            raise PortLost(f"{self.name} is closed")
        return board

    def _listen(self) -> socket.socket:
        try:
            self._listener = socket.create_server(self._address, backlog=1)
        except OSError as error:
            raise PortUnavailable(f"{self.name} cannot be listened on: {error}") from None
        return self._listener
