"""Tests of the evaluation of the long run with a simulated AVR."""

import io
import struct

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from ci.endurance.run_board import CHECK, damaged_frames, is_newer, number_in, wrong_values


def value(number: int, checked: int) -> bytes:
    return struct.pack("<I", number << 16 | checked * CHECK & 0xFFFF)


def test_value_with_a_wrong_check_value_is_wrong() -> None:
    assert number_in(value(5, 5)) == 5
    assert number_in(value(5, 4)) is None


@pytest.mark.parametrize(
    ("number", "other", "expected"),
    [(6, 5, True), (5, 5, False), (4, 5, False), (3, 0xFFFE, True), (0, 0xFFF0, False)],
)
def test_newer_command_is_recognized_when_numbers_start_again(
    number: int, other: int, expected: bool
) -> None:
    assert is_newer(number, other) is expected
    assert not is_newer(None, other)


def test_wrong_values_count_once_and_apart_from_those_in_noise() -> None:
    good, bad, other = value(5, 5), value(5, 4), value(6, 4)
    messages = [(0.0, good), (1.0, bad), (1.1, bad), (2.0, other), (3.0, bad)]
    assert wrong_values(messages, [(0.9, 1.2)]) == (["000678dc", "000578dc"], ["000578dc"])


def test_garbage_bytes_are_not_damaged_frames() -> None:
    counts = {"fault: checksum": 3, "fault: length": 1, "fault: garbage bytes": 99, "sent": 7}
    values = [KeyValue(name, str(count)) for name, count in counts.items()]
    buffer = io.BytesIO()
    DiagnosticArray(status=[DiagnosticStatus(values=values)]).serialize(buffer)
    assert damaged_frames(buffer.getvalue()) == 4
