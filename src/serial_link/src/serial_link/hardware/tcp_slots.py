"""Assignment of boards to slots at one TCP port, across reconnections."""

import ipaddress
import re
from typing import List, Optional, Sequence

#: After this silence, a connection is replaced by a new one from the same address [s]: a board that
#: was reset leaves its old connection open. All boards request the time every 2.5 s.
SAME_BOARD_S = 3.0
#: The same for another address [s]: rosserial's library forgets a host after this time.
OTHER_BOARD_S = 11.0
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")


class BoardSlot:
    """Slot of one board: its name, reserved address and present connection.

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
        """Return whether a board may take the slot: it is empty, or its board is silent too long.

        :param peer: IP address of the board
        :param now: the time [s]
        """
        is_known = peer in (self.peer, self.connected)
        patience = SAME_BOARD_S if is_known else OTHER_BOARD_S
        return self.heard_at is None or now - self.heard_at >= patience


def parse_slots(text: str) -> List[BoardSlot]:
    """Return the slots that a parameter lists.

    :param text: ``NAME`` or ``NAME@ADDRESS``, separated by commas; empty for one unnamed slot
    :raises ValueError: with a message about the first invalid entry
    """
    if not text.strip():
        return [BoardSlot()]
    slots: List[BoardSlot] = []
    for word in text.split(","):
        name, at, address = word.strip().partition("@")
        if not _NAME.fullmatch(name):
            raise ValueError(f"{name!r} is not a namespace: use letters, digits and _")
        if name in {slot.name for slot in slots}:
            raise ValueError(f"{name!r} is listed twice: give each board a different name")
        if at:
            address = _checked(address)
            if address in {slot.address for slot in slots}:
                raise ValueError(f"{address} is listed twice: give each board a different address")
        slots.append(BoardSlot(name, address))
    return slots


def choose_slot(slots: Sequence[BoardSlot], peer: str, now: float) -> Optional[BoardSlot]:
    """Return the slot for a connected board; None while all are taken.

    Preferred is the slot for its address, then its previous slot, then the first slot that had no
    board yet; a single slot is for any board. A connection without a frame may be a port scan: the
    next board waits until that connection sends a frame, closes or times out, and then gets the
    slot.

    :param slots: all
    :param peer: IP address of the board
    :param now: the time [s]
    """
    own = [slot for slot in slots if slot.address == peer]
    others = [slot for slot in slots if not slot.address]
    former = [slot for slot in others if slot.peer == peer]
    former.sort(key=lambda slot: slot.heard_at is not None)  # empty slots first
    unused = [slot for slot in others if not slot.peer]
    candidates = own or [*former, *unused[:1]] or (others if len(slots) == 1 else [])
    return next((slot for slot in candidates if slot.is_free(peer, now)), None)


def explain_refusal(slots: Sequence[BoardSlot]) -> str:
    """Return why a board gets no slot, and what to do.

    :param slots: all
    """
    empty = [slot for slot in slots if slot.heard_at is None]
    reserved = [slot for slot in empty if slot.address or slot.peer]
    if not empty:
        connected = "1 board is" if len(slots) == 1 else f"{len(slots)} boards are"
        return f"{connected} connected already; name each board in tcp_boards"
    if not reserved:
        silent = [slot.connected for slot in slots if slot.heard_at is not None and not slot.peer]
        return (
            f"connections from {' and '.join(silent)} have sent no rosserial frame, and the next "
            "board waits for them; stop the programs that connect there"
        )
    names = " and ".join(f"{slot.name} ({slot.address or slot.peer})" for slot in reserved)
    others = "" if len(reserved) == len(slots) else ", and the others are connected"
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
