"""Transports of a simulated board: a pseudo terminal or a TCP connection."""

import os
import select
import socket
import termios
import tty
from typing import Optional, Protocol

from serial_link.port_mark import is_left_behind, remove_link, remove_own_link, write_mark

_READ_AT_ONCE = 4096


class Transport(Protocol):
    """Connection of a board to its host. Only :meth:`plug` raises."""

    @property
    def is_plugged(self) -> bool:
        """Whether the cable is plugged in."""
        ...

    def plug(self) -> None:
        """Plug the cable in; no effect if that is not possible yet."""
        ...

    def unplug(self) -> None:
        """Pull the cable out."""
        ...

    def wait(self, timeout: float) -> None:
        """Wait for bytes, up to a timeout [s]."""
        ...

    def read(self) -> bytes:
        """Return the bytes received; empty without any."""
        ...

    def write(self, data: bytes) -> None:
        """Send bytes; they are lost if the host does not read them."""
        ...


class PtyTransport:
    """Pseudo terminal behind a link with a fixed name, like an adapter's in /dev/serial/by-id.

    The number of the terminal differs each time.

    :param link: path of the link; ``~`` is expanded to the home folder
    """

    def __init__(self, link: str) -> None:
        self._link = os.path.expanduser(link)
        self._fd: Optional[int] = None

    @property
    def is_plugged(self) -> bool:
        """Whether a terminal is open."""
        return self._fd is not None

    def plug(self) -> None:
        """Create a terminal, and the link to it.

        :raises OSError: if the link cannot be created, or is another board's
        """
        fd, terminal = os.openpty()
        try:
            tty.setraw(terminal)  # else it would echo the board's bytes
            os.makedirs(os.path.dirname(self._link) or ".", exist_ok=True)
            is_dead = os.path.islink(self._link) and not os.path.exists(self._link)
            if is_dead or is_left_behind(self._link):
                remove_link(self._link)  # left by a killed board
            self._make_link(os.ttyname(terminal))
            try:
                write_mark(self._link)
            except OSError:
                remove_own_link(self._link, os.ttyname(terminal))
                raise
        except OSError:
            os.close(fd)
            raise
        finally:
            os.close(terminal)
        os.set_blocking(fd, False)
        self._fd = fd

    def _make_link(self, terminal: str) -> None:
        try:
            os.symlink(terminal, self._link)
        except FileExistsError as error:
            why = "another board's, or left by a killed board; if so, remove it"
            raise OSError(error.errno, f"the port exists already: {why}", self._link) from None

    def unplug(self) -> None:
        """Remove the terminal and the link."""
        fd, self._fd = self._fd, None
        if fd is not None:
            os.close(fd)
            remove_link(self._link)

    def wait(self, timeout: float) -> None:
        """Wait for bytes; see :class:`Transport`."""
        poll = select.poll()
        if self._fd is not None:
            poll.register(self._fd, select.POLLIN)
        found = poll.poll(1000.0 * timeout)
        if found and not found[0][1] & select.POLLIN:
            select.select([], [], [], timeout)  # not open in any process: poll would not wait

    def read(self) -> bytes:
        """Return bytes; see :class:`Transport`."""
        try:
            return os.read(self._fd, _READ_AT_ONCE) if self._fd is not None else b""
        except OSError:  # no data, or not open in any process
            return b""

    def write(self, data: bytes) -> None:
        """Send bytes; see :class:`Transport`."""
        try:
            if self._fd is not None:
                os.write(self._fd, data)
        except (OSError, termios.error):
            pass  # buffer full: a serial line loses bytes, too


class TcpTransport:
    """TCP connection to a host, like that of a Wi-Fi board.

    :param address: of the host
    :param port: TCP port
    """

    def __init__(self, address: str, port: int) -> None:
        self._address = (address, port)
        self._socket: Optional[socket.socket] = None

    @property
    def is_plugged(self) -> bool:
        """Whether the connection is open."""
        return self._socket is not None

    def plug(self) -> None:
        """Connect, if the host listens."""
        try:
            connected = socket.create_connection(self._address, 0.2)
            connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connected.settimeout(0.0)
            self._socket = connected
        except OSError:
            self._socket = None

    def unplug(self) -> None:
        """Close the connection."""
        connected, self._socket = self._socket, None
        if connected is not None:
            connected.close()

    def wait(self, timeout: float) -> None:
        """Wait for bytes; see :class:`Transport`."""
        select.select([self._socket] if self._socket else [], [], [], timeout)

    def read(self) -> bytes:
        """Return bytes; see :class:`Transport`. Unplugs if the host disconnects."""
        if self._socket is None:
            return b""
        try:
            data = self._socket.recv(_READ_AT_ONCE)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self.unplug()
        return data

    def write(self, data: bytes) -> None:
        """Send bytes; see :class:`Transport`."""
        try:
            if self._socket is not None:
                self._socket.sendall(data)
        except OSError:  # buffer full, or disconnected: the host has to cope with half a frame
            pass
