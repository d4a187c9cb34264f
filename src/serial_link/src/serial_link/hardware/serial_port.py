"""Serial port, through pyserial."""

import contextlib
import errno
import fcntl
import grp
import os
import select
import termios
from typing import Optional

import serial

from serial_link.hardware.port_users import find_port_users
from serial_link.hardware.ports import PortLost, PortStuck, PortUnavailable
from serial_link.hardware.usb_ports import has_line
from serial_link.port_mark import is_left_behind, remove_link

#: Timeout for writing a frame [s].
_WRITE_S = 0.5
_READ_AT_ONCE = 4096
#: Longest pause within a frame [s]: adapters and hubs may hold bytes back for 0.4 s.
_GAP_S = 0.6
#: Folder of pseudo terminals. After a kill -9 a lock on one would persist for other users.
_PSEUDO = "/dev/pts/"
#: Group whose members may open serial ports, on Debian and its derivatives.
_GROUP = "dialout"


class SerialPort:
    """Serial port, locked for this process.

    A name below /dev/serial/by-id remains valid when the board reappears under another number.

    :param name: path of the port, or of a link to it; ``~`` is expanded to the home folder
    :param baud: bits per second

    :ivar baud: as given; 0 after opening if there is no line behind the port
    """

    gap = _GAP_S

    def __init__(self, name: str, baud: int) -> None:
        self.name, self.baud = os.path.expanduser(name), baud
        self._line_baud = baud
        self._serial: Optional[serial.Serial] = None
        #: Descriptor of the open port, and its poll object; -1 while the port is closed.
        self._fd = -1
        self._poll = select.poll()

    def open(self, timeout: float) -> bool:
        """Open the port; see :class:`.Port`. Does not wait."""
        if is_left_behind(self.name):
            remove_link(self.name)
            raise PortUnavailable(f"{self.name} does not exist: its simulated board was killed")
        if not os.path.exists(self.name):
            raise PortUnavailable(f"{self.name} does not exist: is the board plugged in?")
        held = self._held()
        if held:
            raise PortUnavailable(held)
        try:
            opened = serial.Serial(
                self.name, self._line_baud, timeout=0, write_timeout=_WRITE_S, exclusive=True
            )
            # pyserial's lock stops only programs that ask for it.
            if not os.path.realpath(self.name).startswith(_PSEUDO):
                fcntl.ioctl(opened.fileno(), termios.TIOCEXCL)
        except (OSError, ValueError, termios.error) as error:
            raise PortUnavailable(self._why(error)) from None
        self._poll = select.poll()
        self._fd = opened.fileno()
        self._poll.register(self._fd, select.POLLIN)
        self._serial = opened
        self.baud = self._line_baud if has_line(self.name) else 0
        return True

    def read(self, timeout: float) -> bytes:
        """Return received bytes; see :class:`.Port`."""
        if self._fd < 0:
            raise PortLost(f"{self.name} is closed")
        try:
            if not self._poll.poll(1000.0 * timeout):
                return b""
            # Not through pyserial, which would poll once more.
            data = os.read(self._fd, _READ_AT_ONCE)
        except BlockingIOError:
            return b""
        except OSError as error:  # also of a port that is closed meanwhile
            raise PortLost(f"{self.name} is gone: {error}") from None
        if not data:
            raise PortLost(f"{self.name} is gone: end of file")
        return data

    def on_frame(self) -> None:
        """Do nothing: a serial port has only one board; see :class:`.Port`."""

    def write_now(self, data: bytes) -> bool:
        """Send bytes, unless none are accepted immediately; see :class:`.Port`."""
        if self._fd < 0:
            raise PortLost(f"{self.name} is closed")
        try:
            count = os.write(self._fd, data)
        except BlockingIOError:
            return False
        except OSError as error:
            raise PortLost(f"{self.name} is gone: {error}") from None
        if count < len(data):
            self.write(data[count:])
        return True

    def write(self, data: bytes) -> None:
        """Send bytes; see :class:`.Port`."""
        port = self._serial
        if port is None:
            raise PortLost(f"{self.name} is closed")
        try:
            port.write(data)
        except serial.SerialTimeoutException:
            raise PortStuck(f"{self.name} has accepted no bytes for {_WRITE_S:g} s") from None
        except (OSError, TypeError, ValueError) as error:
            raise PortLost(f"{self.name} is gone: {error}") from None

    def close(self) -> None:
        """Close the port."""
        opened, self._serial = self._serial, None
        self._fd = -1
        if opened is not None:
            with contextlib.suppress(OSError):  # already gone
                # A terminal that another program holds open outlives this, and would stay locked.
                fcntl.ioctl(opened.fileno(), termios.TIOCNXCL)
            with contextlib.suppress(OSError):
                opened.close()

    def release(self) -> None:
        """Close the port."""
        self.close()

    def _held(self) -> str:
        """Return a message about the process that has the port open; empty if not found."""
        users = find_port_users(self.name)
        if not users:
            return ""
        return f"{self.name} is in use by {users[0]}: only one program can talk to a board"

    def _why(self, error: Exception) -> str:
        """Return a message with the cause and the remedy of a failure to open the port."""
        number = getattr(error, "errno", None)
        if number in (errno.EACCES, errno.EPERM):
            return f"{self.name}: permission denied: {self._permission()}"
        if number in (errno.EBUSY, errno.EAGAIN):
            return self._held() or f"{self.name} is in use by a program of another user"
        return f"{self.name} cannot be opened: {error}"

    def _permission(self) -> str:
        try:
            group = grp.getgrgid(os.stat(self.name).st_gid).gr_name
        except (KeyError, OSError):
            group = _GROUP
        group = _GROUP if group == "root" else group
        return (
            f"users of the group {group} may open it: sudo usermod -aG {group} $USER, then log "
            "out and in again"
        )
