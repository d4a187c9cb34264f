"""Seats of the boards at one TCP port: which board is which, over reconnections."""

import ipaddress
import re
from typing import List, Optional, Sequence

#: A connection whose board has said nothing for this long gives way to a new one of the same
#: address [s], as a board that was reset leaves its own open: all ask for the time every 2.5 s.
SAME_BOARD_S = 3.0
#: And to one of another address, after the time in which rosserial's library forgets a host [s].
OTHER_BOARD_S = 11.0
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")


class Seat:
    """Seat of one board.

    :param name: of the board, a namespace; empty for the only one
    :param address: IP address that it is for; empty for any

    :ivar peer: IP address of the last board that sent a frame; empty until one has
    :ivar connected: IP address of the last connection, of a board or of another program
    :ivar heard_at: when it connected or sent its last frame [s]; None while none is connected
    """

    def __init__(self, name: str = "", address: str = "") -> None:
        self.name, self.address = name, address
        self.peer = self.connected = ""
        self.heard_at: Optional[float] = None

    def is_free(self, peer: str, now: float) -> bool:
        """Tell whether a board may have it: it is empty, or its board is silent for too long.

        :param peer: IP address of the board
        :param now: the time [s]
        """
        is_known = peer in (self.peer, self.connected)
        patience = SAME_BOARD_S if is_known else OTHER_BOARD_S
        return self.heard_at is None or now - self.heard_at >= patience


def parse_seats(text: str) -> List[Seat]:
    """Return the seats that a parameter lists.

    :param text: ``NAME`` or ``NAME@ADDRESS``, separated by commas; empty for one without a name
    :raises ValueError: with a sentence about the first that is invalid
    """
    if not text.strip():
        return [Seat()]
    seats: List[Seat] = []
    for word in text.split(","):
        name, at, address = word.strip().partition("@")
        if not _NAME.fullmatch(name):
            raise ValueError(f"{name!r} is not a namespace: use letters, digits and _")
        if name in {seat.name for seat in seats}:
            raise ValueError(f"{name!r} is there twice: name each board differently")
        if at:
            address = _checked(address)
            if address in {seat.address for seat in seats}:
                raise ValueError(f"{address} is there twice: one board has one address")
        seats.append(Seat(name, address))
    return seats


def choose_seat(seats: Sequence[Seat], peer: str, now: float) -> Optional[Seat]:
    """Return the seat for a board that has connected; None while all are taken.

    The seat of its address comes first, then the one that it had, then the first that no board had;
    the only seat is for any board. A connection that has sent no frame may be a port probe: the
    next board waits until it sends one, closes or is silent for too long, and then gets that seat.

    :param seats: all
    :param peer: IP address of the board
    :param now: the time [s]
    """
    own = [seat for seat in seats if seat.address == peer]
    others = [seat for seat in seats if not seat.address]
    former = [seat for seat in others if seat.peer == peer]
    former.sort(key=lambda seat: seat.heard_at is not None)  # an empty one first
    unused = [seat for seat in others if not seat.peer]
    candidates = own or [*former, *unused[:1]] or (others if len(seats) == 1 else [])
    return next((seat for seat in candidates if seat.is_free(peer, now)), None)


def explain_refusal(seats: Sequence[Seat]) -> str:
    """Return why a board gets none of the seats, and what to do.

    :param seats: all
    """
    empty = [seat for seat in seats if seat.heard_at is None]
    reserved = [seat for seat in empty if seat.address or seat.peer]
    if not empty:
        return f"all of {len(seats)} are connected; name each board in tcp_boards"
    if not reserved:
        silent = [seat.connected for seat in seats if seat.heard_at is not None and not seat.peer]
        return (
            f"connections of {' and '.join(silent)} have sent no frame of rosserial, and the next "
            "board waits for them; end the programs that connect there"
        )
    names = " and ".join(f"{seat.name} ({seat.address or seat.peer})" for seat in reserved)
    others = "" if len(reserved) == len(seats) else ", and the others are connected"
    one, several = "is reserved for the board that had it", "are reserved for boards that had them"
    return (
        f"{names} {one if len(reserved) == 1 else several}{others}; give each board a fixed "
        "address and name it in tcp_boards, as in left@192.168.1.20, or restart the node to forget "
        "the addresses"
    )


def _checked(address: str) -> str:
    try:
        return str(ipaddress.IPv4Address(address))
    except ValueError:
        raise ValueError(f"{address!r} is not an IPv4 address, such as 192.168.1.20") from None
