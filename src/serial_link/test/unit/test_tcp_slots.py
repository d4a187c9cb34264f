"""Seats of boards at one TCP port."""

from typing import List, Optional

import pytest

from serial_link.hardware.tcp_slots import (
    OTHER_BOARD_S,
    SAME_BOARD_S,
    BoardSlot,
    choose_slot,
    explain_refusal,
    parse_slots,
)

A, B, C = "10.0.0.1", "10.0.0.2", "10.0.0.3"


def connect(
    slots: List[BoardSlot], peer: str, now: float = 0.0, is_board: bool = True
) -> Optional[str]:
    slot = choose_slot(slots, peer, now)
    if slot is None:
        return None
    slot.connected, slot.heard_at = peer, now
    if is_board:  # its first frame
        slot.peer = peer
    return slot.name


def test_port_scan_reserves_no_slot() -> None:
    slots = parse_slots("left,right")
    assert connect(slots, C, is_board=False) == "left"
    assert connect(slots, A, 0.9 * OTHER_BOARD_S) is None  # not right, which is for the second
    slots[0].heard_at = None
    assert connect(slots, A) == "left" and connect(slots, B) == "right"
    slots = parse_slots("left,right")
    connect(slots, C, is_board=False)  # it stays connected
    assert connect(slots, A, OTHER_BOARD_S) == "left" and connect(slots, B) == "right"


def test_refusal_names_the_slots_that_are_reserved() -> None:
    slots = parse_slots("left,right")
    connect(slots, C, is_board=False)
    assert f"connections from {C} have sent no rosserial frame" in explain_refusal(slots)
    connect(slots, A, OTHER_BOARD_S), connect(slots, B)
    assert explain_refusal(slots).startswith("2 boards are connected already")
    slots[0].heard_at = None
    why = f"left ({A}) is reserved for the board that had it, and the others are connected; "
    assert explain_refusal(slots).startswith(why)
    slots[1].heard_at = None
    why = f"left ({A}) and right ({B}) are reserved for boards that had them; give each "
    assert explain_refusal(slots).startswith(why)
    assert explain_refusal(parse_slots(f"left@{A},right@{B}")).startswith(why)
    slots = parse_slots("left,right,third")
    connect(slots, A), connect(slots, C, is_board=False)
    assert explain_refusal(slots).startswith(f"connections from {C} have sent no")
    slots = parse_slots("")
    connect(slots, A)
    assert explain_refusal(slots).startswith("1 board is connected already")


def test_boards_get_slots_in_the_order_of_their_first_connection_and_keep_them() -> None:
    slots = parse_slots("left, right")
    assert connect(slots, A) == "left"
    slots[0].heard_at = None
    assert connect(slots, A) == "left" and connect(slots, B) == "right"
    assert connect(slots, C) is None
    for slot in slots:
        slot.heard_at = None
    assert connect(slots, C) is None  # both are away, and come back
    assert connect(slots, B) == "right" and connect(slots, A) == "left"


def test_addresses_determine_slots_in_any_order() -> None:
    slots = parse_slots(f"left@{A},right@{B}")
    assert connect(slots, C) is None
    assert connect(slots, B) == "right" and connect(slots, A) == "left"
    mixed = parse_slots(f"left@{A},others")
    assert connect(mixed, A) == "left" and connect(mixed, A) is None
    assert connect(mixed, C) == "others"


def test_board_that_was_reset_gets_its_slot_when_its_old_connection_is_silent() -> None:
    slots = parse_slots("left,right")
    connect(slots, A), connect(slots, B)
    assert connect(slots, A, 0.9 * SAME_BOARD_S) is None
    assert connect(slots, A, SAME_BOARD_S) == "left"


def test_board_that_only_requests_the_time_keeps_its_slot() -> None:
    slots = parse_slots("")
    connect(slots, A)
    assert connect(slots, A, 2.5 + 0.4) is None  # its period, and a request that comes late


def test_board_that_was_reset_before_its_first_frame_waits_no_longer() -> None:
    slots = parse_slots("")
    connect(slots, A, is_board=False)
    assert connect(slots, A, 0.9 * SAME_BOARD_S) is None
    assert connect(slots, A, SAME_BOARD_S) == ""
    connect(slots, B, OTHER_BOARD_S + SAME_BOARD_S, is_board=False)  # a program in between
    assert connect(slots, A, OTHER_BOARD_S + 2.0 * SAME_BOARD_S) == ""


def test_only_slot_is_for_any_board_and_an_other_address_waits_longer() -> None:
    slots = parse_slots("")
    assert [slot.name for slot in slots] == [""]
    assert connect(slots, A) == "" and connect(slots, B, 0.9 * OTHER_BOARD_S) is None
    assert connect(slots, B, OTHER_BOARD_S) == ""


def test_boards_with_same_address_are_distinguished_by_order() -> None:
    slots = parse_slots("left,right")
    assert connect(slots, A) == "left" and connect(slots, A) == "right"
    slots[0].heard_at = None
    assert connect(slots, A) == "left"
    slots[1].heard_at = None
    assert connect(slots, A, SAME_BOARD_S) == "right"  # the other is silent, this one is empty


@pytest.mark.parametrize(
    "text, why",
    [
        ("le-ft", "'le-ft' is not a namespace"),
        ("left,,right", "'' is not a namespace"),
        ("left,left", "'left' is listed twice"),
        (f"left@{A},right@{A}", f"{A} is listed twice"),
        ("left@robot", "'robot' is not an IPv4 address"),
        ("left@::1", "'::1' is not an IPv4 address"),
    ],
)
def test_invalid_list_is_rejected_with_message(text: str, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        parse_slots(text)
