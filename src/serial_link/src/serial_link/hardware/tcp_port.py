"""TCP listener for Wi-Fi boards, and a port for each board slot (one ROS namespace per slot)."""

import contextlib
import os
import select
import socket
import threading
import time
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence

from serial_link.hardware.ports import PortLost, PortStuck, PortUnavailable
from serial_link.hardware.tcp_slots import BoardSlot, choose_slot, explain_refusal

_WRITE_S = 0.5
_READ_AT_ONCE = 4096
#: Longest pause within a frame [s]: long, because TCP resends lost packets.
_GAP_S = 5.0
#: Longest wait of a board for a slot [s]; longer than a silent board keeps its slot.
_SLOT_S = 12.0
#: Most waiting boards.
_MOST_WAITING = 16


class _Connection(NamedTuple):
    """Connection of a board that its port has not taken yet."""

    board: socket.socket
    address: str
    port: int
    came_at: float


class TcpServer:
    """Listener for the boards at one TCP port, each of which has a slot.

    It has no thread: the ports poll it.

    :param address: address to listen on: ``localhost``, or one that other machines can reach
    :param number: TCP port
    :param slots: of the boards
    :param on_refused: receives a message about each board that gets no slot

    :ivar ports: one for each slot, in the same order
    """

    def __init__(
        self,
        address: str,
        number: int,
        slots: Sequence[BoardSlot] = (),
        on_refused: Callable[[str], None] = lambda text: None,
    ) -> None:
        self._address, self._on_refused = (address, number), on_refused
        self.name = f"tcp {address}:{number}"
        self._slots = list(slots) or [BoardSlot()]
        self._lock = threading.Lock()
        self._listener: Optional[socket.socket] = None
        self._waiting: List[_Connection] = []
        self._assigned: Dict[BoardSlot, _Connection] = {}
        self.ports = [TcpPort(self, slot) for slot in self._slots]
        self._in_use = len(self.ports)

    def listen(self) -> List[socket.socket]:
        """Return the sockets to wait for; give waiting boards their slots.

        :returns: the listener; empty while the maximum number of boards waits, when the
            listener would be ready all the time
        :raises PortUnavailable: if the address cannot be bound
        """
        with self._lock:
            listener = self._listener or self._open()
            self._accept(listener)
            refused = self._assign_slots(time.monotonic())
            is_full = len(self._waiting) >= _MOST_WAITING
        for text in refused:  # without the lock: logging may be slow
            self._on_refused(text)
        return [] if is_full else [listener]

    def has_connection(self, slot: BoardSlot) -> bool:
        """Return whether a board waits for its port."""
        return slot in self._assigned

    def take_connection(self, slot: BoardSlot) -> Optional[_Connection]:
        """Return the connection of a board that was given a slot, once."""
        with self._lock:
            return self._assigned.pop(slot, None)

    def release(self) -> None:
        """Stop listening when the last port is released."""
        with self._lock:
            self._in_use -= 1
            if self._in_use:
                return
            listener, self._listener = self._listener, None
            connections = [*self._waiting, *self._assigned.values()]
            self._waiting.clear()
            self._assigned.clear()
        for connection in connections:
            connection.board.close()
        if listener is not None:
            listener.close()

    def _open(self) -> socket.socket:
        try:
            listener = socket.create_server(self._address, backlog=len(self._slots))
        except OSError as error:
            raise PortUnavailable(f"{self.name} cannot listen: {error}") from None
        listener.setblocking(False)
        self._listener = listener
        return listener

    def _accept(self, listener: socket.socket) -> None:
        while len(self._waiting) < _MOST_WAITING:
            try:
                board, (address, port) = listener.accept()
            except OSError:  # no more boards, or already gone
                return
            board.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            board.settimeout(_WRITE_S)
            self._waiting.append(_Connection(board, address, port, time.monotonic()))

    def _assign_slots(self, now: float) -> List[str]:
        """Give boards their slots; return a message about each rejected board."""
        refused: List[str] = []
        for connection in list(self._waiting):
            slot = choose_slot(self._slots, connection.address, now)
            if slot is not None and slot not in self._assigned:
                slot.connected, slot.heard_at = connection.address, now
                self._assigned[slot] = connection
            elif _has_left(connection.board):
                connection.board.close()
            elif now - connection.came_at > _SLOT_S:
                connection.board.close()
                refused.append(
                    f"{self.name}: the board at {connection.address} is refused: "
                    f"{explain_refusal(self._slots)}"
                )
            else:
                continue
            self._waiting.remove(connection)
        return refused


class TcpPort:
    """Port of the board in one slot; a new connection replaces a silent one.

    A board that was reset leaves its old connection open, and connects again.

    :param server: shared by all boards
    :param slot: of this board
    """

    baud, gap = 0, _GAP_S

    def __init__(self, server: TcpServer, slot: BoardSlot) -> None:
        self._server, self._slot = server, slot
        self._own_name = self.name = f"{server.name} {slot.name}".rstrip()
        self._board: Optional[socket.socket] = None
        self._address = ""

    def open(self, timeout: float) -> bool:
        """Wait for a board; see :class:`.Port`."""
        listeners = self._server.listen()
        if not self._server.has_connection(self._slot):
            select.select(listeners, [], [], timeout)
            self._server.listen()
        connection = self._server.take_connection(self._slot)
        if connection is None:
            return False
        self._board, self._address = connection.board, connection.address
        self.name = f"{self._own_name} from {connection.address}:{connection.port}"
        return True

    def read(self, timeout: float) -> bytes:
        """Return received bytes; see :class:`.Port`."""
        board = self._connected()
        try:
            listeners = self._server.listen()
            if not self._server.has_connection(self._slot):
                ready = select.select([board, *listeners], [], [], timeout)[0]
            if self._server.has_connection(self._slot):
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
        """Reserve the slot for the board's address; see :class:`.Port`."""
        self._slot.peer, self._slot.heard_at = self._address, time.monotonic()

    def write_now(self, data: bytes) -> bool:
        """Send bytes, unless none are accepted now; see :class:`.Port` and :meth:`write`."""
        board = self._connected()
        try:
            # Not through the socket, whose send() blocks up to its timeout.
            count = os.write(board.fileno(), data)
        except BlockingIOError:
            return False
        except (OSError, ValueError) as error:
            raise PortLost(f"{self.name} is gone: {error}") from None
        if count < len(data):
            self._send_all(board, data[count:])
        return True

    def write(self, data: bytes) -> None:
        """Send bytes; see :class:`.Port`.

        A partial write closes the connection: the next message would be taken for the rest.
        """
        board = self._connected()
        try:
            is_free = select.select([], [board], [], _WRITE_S)[1]
        except (OSError, ValueError) as error:
            raise PortLost(f"{self.name} is gone: {error}") from None
        if not is_free:
            raise PortStuck(f"{self.name} has accepted no bytes for {_WRITE_S:g} s")
        self._send_all(board, data)

    def _send_all(self, board: socket.socket, data: bytes) -> None:
        """Send all bytes, or close the connection."""
        try:
            board.sendall(data)
        except socket.timeout:
            with contextlib.suppress(OSError):  # already gone
                board.shutdown(socket.SHUT_RDWR)  # wakes the reading thread
            raise PortStuck(
                f"{self.name} has accepted only part of a message within {_WRITE_S:g} s"
            ) from None
        except (OSError, ValueError) as error:
            raise PortLost(f"{self.name} is gone: {error}") from None

    def close(self) -> None:
        """Close the board's connection; the server keeps listening."""
        board, self._board = self._board, None
        self.name = self._own_name
        if board is not None:
            board.close()
        if not self._server.has_connection(self._slot):
            self._slot.heard_at = None

    def release(self) -> None:
        """Close the port permanently; the server continues for the other ports."""
        self.close()
        self._server.release()

    def _connected(self) -> socket.socket:
        board = self._board
        if board is None:
            raise PortLost(f"{self.name} is closed")
        return board


def _has_left(board: socket.socket) -> bool:
    """Return whether a board has closed its connection."""
    if not select.select([board], [], [], 0.0)[0]:
        return False
    try:
        return not board.recv(1, socket.MSG_PEEK)
    except OSError:
        return True
