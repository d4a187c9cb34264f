"""Interface of a port to a board, such as a serial port, and the exceptions of ports."""

from typing import Protocol


class PortUnavailable(OSError):
    """A port that cannot be opened now; the text gives the cause and the remedy."""


class PortLost(OSError):
    """A port that was lost while open; the text gives the cause."""


class PortStuck(OSError):
    """A port that accepts no more bytes at the moment."""


class Port(Protocol):
    """Port of a board. One thread reads; others write, one at a time."""

    #: Display name.
    name: str
    #: Bits per second of the line; 0 for a network connection.
    baud: int
    #: After a pause of this length within a frame, the rest will not arrive [s].
    gap: float

    def open(self, timeout: float) -> bool:
        """Open the port.

        :param timeout: longest wait [s]
        :returns: whether it is open; False if no board has connected yet
        :raises PortUnavailable: if it cannot be opened
        """
        ...

    def read(self, timeout: float) -> bytes:
        """Return the received bytes.

        :param timeout: longest wait for the first byte [s]
        :returns: empty after the timeout
        :raises PortLost: if the port was lost
        """
        ...

    def on_frame(self) -> None:
        """Note that a board is connected: an undamaged frame was received."""
        ...

    def write_now(self, data: bytes) -> bool:
        """Send bytes, unless the system accepts none without blocking.

        :returns: whether the bytes were sent
        :raises PortLost: if the port was lost
        :raises PortStuck: if the port accepts only part of the bytes
        """
        ...

    def write(self, data: bytes) -> None:
        """Send bytes.

        :raises PortLost: if the port was lost
        :raises PortStuck: if it accepts no bytes; some may have been sent
        """
        ...

    def close(self) -> None:
        """Close the port; it may be opened again. No effect if it is not open."""
        ...

    def release(self) -> None:
        """Close the port permanently."""
        ...
