"""Assignment of boards to seats at one TCP port, across reconnections."""

import ipaddress
import re
from typing import List, Optional, Sequence

#: After this silence, a connection is replaced by a new one from the same address [s]: a board that
#: was reset leaves its old connection open. All boards request the time every 2.5 s.
SAME_BOARD_S = 3.0
#: The same for another address [s]: rosserial's library forgets a host after this time.
OTHER_BOARD_S = 11.0
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")


class Seat:
    """Seat of one board.

    :param name: of the board, a namespace; empty for a single board
    :param address: IP address it is reserved for; empty for any

    :ivar peer: IP address of the last board that sent a frame; empty if none has
    :ivar connected: IP address of the last connection, of a board or of another program
    :ivar heard_at: time of the connection or of its last frame [s]; None while not connected
    """

    def __init__(self, name: str = "", address: str = "") -> None:
        self.name, self.address = name, address
        self.peer = self.connected = ""
        self.heard_at: Optional[float] = None

    def is_free(self, peer: str, now: float) -> bool:
        """Return whether a board may take the seat: it is empty, or its board is silent too long.

        :param peer: IP address of the board
        :param now: the time [s]
        """
        is_known = peer in (self.peer, self.connected)
        patience = SAME_BOARD_S if is_known else OTHER_BOARD_S
        return self.heard_at is None or now - self.heard_at >= patience


def parse_seats(text: str) -> List[Seat]:
    """Return the seats that a parameter lists.

    :param text: ``NAME`` or ``NAME@ADDRESS``, separated by commas; empty for one unnamed seat
    :raises ValueError: with a message about the first invalid entry
    """
    if not text.strip():
        return [Seat()]
    seats: List[Seat] = []
    for word in text.split(","):
        name, at, address = word.strip().partition("@")
        if not _NAME.fullmatch(name):
            raise ValueError(f"{name!r} is not a namespace: use letters, digits and _")
        if name in {seat.name for seat in seats}:
            raise ValueError(f"{name!r} is listed twice: give each board a different name")
        if at:
            address = _checked(address)
            if address in {seat.address for seat in seats}:
                raise ValueError(f"{address} is listed twice: give each board a different address")
        seats.append(Seat(name, address))
    return seats


def choose_seat(seats: Sequence[Seat], peer: str, now: float) -> Optional[Seat]:
    """Return the seat for a connected board; None while all are taken.

    Preferred is the seat for its address, then its previous seat, then the first seat that had no
    board yet; a single seat is for any board. A connection without a frame may be a port scan: the
    next board waits until that connection sends a frame, closes or times out, and then gets the
    seat.

    :param seats: all
    :param peer: IP address of the board
    :param now: the time [s]
    """
    own = [seat for seat in seats if seat.address == peer]
    others = [seat for seat in seats if not seat.address]
    former = [seat for seat in others if seat.peer == peer]
    former.sort(key=lambda seat: seat.heard_at is not None)  # empty seats first
    unused = [seat for seat in others if not seat.peer]
    candidates = own or [*former, *unused[:1]] or (others if len(seats) == 1 else [])
    return next((seat for seat in candidates if seat.is_free(peer, now)), None)


def explain_refusal(seats: Sequence[Seat]) -> str:
    """Return why a board gets no seat, and what to do.

    :param seats: all
    """
    empty = [seat for seat in seats if seat.heard_at is None]
    reserved = [seat for seat in empty if seat.address or seat.peer]
    if not empty:
        return f"all of {len(seats)} are connected; name each board in tcp_boards"
    if not reserved:
        silent = [seat.connected for seat in seats if seat.heard_at is not None and not seat.peer]
        return (
            f"connections from {' and '.join(silent)} have sent no rosserial frame, and the next "
            "board waits for them; stop the programs that connect there"
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
