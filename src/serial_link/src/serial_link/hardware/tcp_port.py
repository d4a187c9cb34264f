"""TCP port for boards with Wi-Fi; each board has a seat, which stands for its namespace."""

import contextlib
import select
import socket
import threading
import time
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence

from serial_link.hardware.ports import PortLost, PortStuck, PortUnavailable
from serial_link.hardware.tcp_seats import Seat, choose_seat, explain_refusal

_WRITE_S = 0.5
_READ_AT_ONCE = 4096
#: Longest pause within a frame [s]: long, because TCP resends lost packets.
_GAP_S = 5.0
#: Longest wait of a board for a seat [s]; longer than a silent board keeps its seat.
_SEAT_S = 12.0
#: Most waiting boards.
_MOST_WAITING = 16


class _Caller(NamedTuple):
    """A connected board without a seat yet."""

    connection: socket.socket
    address: str
    port: int
    came_at: float


class TcpServer:
    """Listener for the boards at one TCP port, each of which has a seat.

    It has no thread: the ports poll it.

    :param address: address to listen on: ``localhost``, or one that other machines can reach
    :param number: TCP port
    :param seats: of the boards
    :param on_refused: receives a message about each board that gets no seat

    :ivar ports: one for each seat, in the same order
    """

    def __init__(
        self,
        address: str,
        number: int,
        seats: Sequence[Seat] = (),
        on_refused: Callable[[str], None] = lambda text: None,
    ) -> None:
        self._address, self._on_refused = (address, number), on_refused
        self.name = f"tcp {address}:{number}"
        self._seats = list(seats) or [Seat()]
        self._lock = threading.Lock()
        self._listener: Optional[socket.socket] = None
        self._waiting: List[_Caller] = []
        self._seated: Dict[Seat, _Caller] = {}
        self.ports = [TcpPort(self, seat) for seat in self._seats]
        self._in_use = len(self.ports)

    def listen(self) -> List[socket.socket]:
        """Return the sockets to wait for; give waiting boards their seats.

        :returns: the listener; empty while the maximum number of boards waits, when the
            listener would be ready all the time
        :raises PortUnavailable: if the address cannot be bound
        """
        with self._lock:
            listener = self._listener or self._open()
            self._accept(listener)
            refused = self._seat(time.monotonic())
            is_full = len(self._waiting) >= _MOST_WAITING
        for text in refused:  # without the lock: logging may be slow
            self._on_refused(text)
        return [] if is_full else [listener]

    def has_caller(self, seat: Seat) -> bool:
        """Return whether a board waits for its port."""
        return seat in self._seated

    def take(self, seat: Seat) -> Optional[_Caller]:
        """Return the board that was given a seat, once."""
        with self._lock:
            return self._seated.pop(seat, None)

    def release(self) -> None:
        """Stop listening when the last port is released."""
        with self._lock:
            self._in_use -= 1
            if self._in_use:
                return
            listener, self._listener = self._listener, None
            callers = [*self._waiting, *self._seated.values()]
            self._waiting.clear()
            self._seated.clear()
        for caller in callers:
            caller.connection.close()
        if listener is not None:
            listener.close()

    def _open(self) -> socket.socket:
        try:
            listener = socket.create_server(self._address, backlog=len(self._seats))
        except OSError as error:
            raise PortUnavailable(f"{self.name} cannot listen: {error}") from None
        listener.setblocking(False)
        self._listener = listener
        return listener

    def _accept(self, listener: socket.socket) -> None:
        while len(self._waiting) < _MOST_WAITING:
            try:
                connection, (address, port) = listener.accept()
            except OSError:  # no more boards, or already gone
                return
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connection.settimeout(_WRITE_S)
            self._waiting.append(_Caller(connection, address, port, time.monotonic()))

    def _seat(self, now: float) -> List[str]:
        """Give boards their seats; return a message about each rejected board."""
        refused: List[str] = []
        for caller in list(self._waiting):
            seat = choose_seat(self._seats, caller.address, now)
            if seat is not None and seat not in self._seated:
                seat.connected, seat.heard_at = caller.address, now
                self._seated[seat] = caller
            elif _has_left(caller.connection):
                caller.connection.close()
            elif now - caller.came_at > _SEAT_S:
                caller.connection.close()
                refused.append(
                    f"{self.name}: the board at {caller.address} is refused: "
                    f"{explain_refusal(self._seats)}"
                )
            else:
                continue
            self._waiting.remove(caller)
        return refused


class TcpPort:
    """Port of the board in one seat; a new connection replaces a silent one.

    A board that was reset leaves its old connection open, and connects again.

    :param server: shared by all boards
    :param seat: of this board
    """

    baud, gap = 0, _GAP_S

    def __init__(self, server: TcpServer, seat: Seat) -> None:
        self._server, self._seat = server, seat
        self._own_name = self.name = f"{server.name} {seat.name}".rstrip()
        self._board: Optional[socket.socket] = None
        self._address = ""

    def open(self, timeout: float) -> bool:
        """Wait for a board; see :class:`.Port`."""
        listeners = self._server.listen()
        if not self._server.has_caller(self._seat):
            select.select(listeners, [], [], timeout)
            self._server.listen()
        caller = self._server.take(self._seat)
        if caller is None:
            return False
        self._board, self._address = caller.connection, caller.address
        self.name = f"{self._own_name} from {caller.address}:{caller.port}"
        return True

    def read(self, timeout: float) -> bytes:
        """Return received bytes; see :class:`.Port`."""
        board = self._connected()
        try:
            listeners = self._server.listen()
            if not self._server.has_caller(self._seat):
                ready = select.select([board, *listeners], [], [], timeout)[0]
                if any(listener in ready for listener in listeners):
                    self._server.listen()
            if self._server.has_caller(self._seat):
                raise PortLost(f"{self.name}: replaced by a new connection")
            if board not in ready:
                return b""
            data = board.recv(_READ_AT_ONCE)
        except PortLost:
            raise
        except (OSError, ValueError) as error:
            raise PortLost(f"{self.name} is gone: {error}") from None
        if not data:
            raise PortLost(f"{self.name}: the connection was closed")
        return data

    def on_frame(self) -> None:
        """Reserve the seat for the board's address; see :class:`.Port`."""
        self._seat.peer, self._seat.heard_at = self._address, time.monotonic()

    def write(self, data: bytes) -> None:
        """Send bytes; see :class:`.Port`.

        A partial write closes the connection: the next message would be taken for the rest.
        """
        board = self._connected()
        try:
            if not select.select([], [board], [], _WRITE_S)[1]:
                raise PortStuck(f"{self.name} accepts no bytes for {_WRITE_S:g} s")
            board.sendall(data)
        except PortStuck:
            raise
        except socket.timeout:
            with contextlib.suppress(OSError):  # already gone
                board.shutdown(socket.SHUT_RDWR)  # wakes the reading thread
            raise PortStuck(
                f"{self.name} accepts only part of a message for {_WRITE_S:g} s"
            ) from None
        except (OSError, ValueError) as error:
            raise PortLost(f"{self.name} is gone: {error}") from None

    def close(self) -> None:
        """Close the board's connection; the server keeps listening."""
        board, self._board = self._board, None
        self.name = self._own_name
        if board is not None:
            board.close()
        if not self._server.has_caller(self._seat):
            self._seat.heard_at = None

    def release(self) -> None:
        """Close the port permanently; the server continues for the other ports."""
        self.close()
        self._server.release()

    def _connected(self) -> socket.socket:
        board = self._board
        if board is None:
            raise PortLost(f"{self.name} is closed")
        return board


def _has_left(connection: socket.socket) -> bool:
    """Return whether a board has closed its connection."""
    if not select.select([connection], [], [], 0.0)[0]:
        return False
    try:
        return not connection.recv(1, socket.MSG_PEEK)
    except OSError:
        return True
