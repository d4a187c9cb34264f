"""Interface of ports."""

from typing import Protocol


class PortUnavailable(OSError):
    """A port that cannot be opened now; the text says why, and what helps."""


class PortLost(OSError):
    """A port that was open and is gone; the text says how."""


class PortStuck(OSError):
    """A port that takes nothing more at the moment."""


class Port(Protocol):
    """Port of a board. One thread reads, another one writes."""

    #: What it is called.
    name: str
    #: Bits a second of its line; 0 for a network connection.
    baud: int
    #: A frame whose bytes stop coming for this long will not go on [s].
    gap: float

    def open(self, timeout: float) -> bool:
        """Open it.

        :param timeout: longest wait [s]
        :returns: whether it is open; False if no board has connected yet
        :raises PortUnavailable: if it cannot be
        """
        ...

    def read(self, timeout: float) -> bytes:
        """Return what has arrived.

        :param timeout: longest wait for something [s]
        :returns: nothing if nothing came
        :raises PortLost: if it is gone
        """
        ...

    def on_frame(self) -> None:
        """Note that a board is there: a frame without damage was among the bytes read."""
        ...

    def write(self, data: bytes) -> None:
        """Send bytes.

        :raises PortLost: if it is gone
        :raises PortStuck: if it takes nothing; part of the bytes may be sent
        """
        ...

    def close(self) -> None:
        """Close it, to be opened again; without effect if it is not open."""
        ...

    def release(self) -> None:
        """Close it for good."""
        ...
