"""Seats of boards at one TCP port."""

from typing import List, Optional

import pytest

from serial_link.hardware.tcp_seats import (
    OTHER_BOARD_S,
    SAME_BOARD_S,
    Seat,
    choose_seat,
    explain_refusal,
    parse_seats,
)

A, B, C = "10.0.0.1", "10.0.0.2", "10.0.0.3"


def connect(seats: List[Seat], peer: str, now: float = 0.0, is_board: bool = True) -> Optional[str]:
    seat = choose_seat(seats, peer, now)
    if seat is None:
        return None
    seat.connected, seat.heard_at = peer, now
    if is_board:  # its first frame
        seat.peer = peer
    return seat.name


def test_port_scan_reserves_no_seat() -> None:
    seats = parse_seats("left,right")
    assert connect(seats, C, is_board=False) == "left"
    assert connect(seats, A, 0.9 * OTHER_BOARD_S) is None  # not right, which is for the second
    seats[0].heard_at = None
    assert connect(seats, A) == "left" and connect(seats, B) == "right"
    seats = parse_seats("left,right")
    connect(seats, C, is_board=False)  # it stays connected
    assert connect(seats, A, OTHER_BOARD_S) == "left" and connect(seats, B) == "right"


def test_refusal_names_the_seats_that_are_reserved() -> None:
    seats = parse_seats("left,right")
    connect(seats, C, is_board=False)
    assert f"connections from {C} have sent no rosserial frame" in explain_refusal(seats)
    connect(seats, A, OTHER_BOARD_S), connect(seats, B)
    assert explain_refusal(seats).startswith("all of 2 are connected")
    seats[0].heard_at = None
    why = f"left ({A}) is reserved for the board that had it, and the others are connected; "
    assert explain_refusal(seats).startswith(why)
    seats[1].heard_at = None
    why = f"left ({A}) and right ({B}) are reserved for boards that had them; give each "
    assert explain_refusal(seats).startswith(why)


def test_boards_get_seats_in_the_order_of_their_first_connection_and_keep_them() -> None:
    seats = parse_seats("left, right")
    assert connect(seats, A) == "left" and connect(seats, B) == "right"
    assert connect(seats, C) is None
    for seat in seats:
        seat.heard_at = None
    assert connect(seats, C) is None  # both are away, and come back
    assert connect(seats, B) == "right" and connect(seats, A) == "left"


def test_addresses_determine_seats_in_any_order() -> None:
    seats = parse_seats(f"left@{A},right@{B}")
    assert connect(seats, B) == "right" and connect(seats, A) == "left"
    assert connect(seats, C) is None
    mixed = parse_seats(f"left@{A},others")
    assert connect(mixed, C) == "others" and connect(mixed, A) == "left"


def test_board_that_was_reset_gets_its_seat_when_its_old_connection_is_silent() -> None:
    seats = parse_seats("left,right")
    connect(seats, A), connect(seats, B)
    assert connect(seats, A, 0.9 * SAME_BOARD_S) is None
    assert connect(seats, A, SAME_BOARD_S) == "left"


def test_only_seat_is_for_any_board_and_an_other_address_waits_longer() -> None:
    seats = parse_seats("")
    assert [seat.name for seat in seats] == [""]
    assert connect(seats, A) == "" and connect(seats, B, 0.9 * OTHER_BOARD_S) is None
    assert connect(seats, B, OTHER_BOARD_S) == ""


def test_boards_with_same_address_are_distinguished_by_order() -> None:
    seats = parse_seats("left,right")
    assert connect(seats, A) == "left" and connect(seats, A) == "right"
    seats[0].heard_at = None
    assert connect(seats, A) == "left"


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
        parse_seats(text)
