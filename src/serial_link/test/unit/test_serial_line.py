"""A serial line: its pace, and damage."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from serial_link.device.serial_line import SerialLine, add_noise


def test_bytes_arrive_at_baud_rate() -> None:
    line = SerialLine(1000)  # a byte takes 10 ms
    line.put(1.0, b"abcd")
    assert line.waiting == 4 and line.next_due() == pytest.approx(1.04)
    assert line.arrived(1.005) == b""
    assert line.arrived(1.025) == b"ab"
    line.put(1.03, b"ef")
    assert line.arrived(1.035) == b"c"
    assert line.arrived(1.045) == b"d" and line.waiting == 2
    assert line.next_due() == pytest.approx(1.06)
    assert line.arrived(2.0) == b"ef" and line.next_due() == math.inf


@given(st.lists(st.tuples(st.floats(0.0, 0.5), st.binary(max_size=30)), max_size=20))
def test_no_byte_is_lost_or_faster_than_the_line(steps: list) -> None:
    line, now, sent, arrived = SerialLine(9600), 0.0, b"", b""
    for pause, data in steps:
        now += pause
        line.put(now, data)
        sent += data
        arrived += line.arrived(now)
        assert sent.startswith(arrived) and len(arrived) <= now * 960.0 + 1.0
        assert line.waiting == len(sent) - len(arrived)
    assert arrived + line.arrived(now + 10.0) == sent


def test_line_without_rate_has_no_delay_and_cleared_line_is_empty() -> None:
    line = SerialLine(0)
    line.put(1.0, b"abc")
    assert line.arrived(1.0) == b"abc"
    line.put(1.0, b"abc")
    line.clear()
    assert line.arrived(9.0) == b"" and line.waiting == 0


def test_cleared_line_is_free() -> None:
    line = SerialLine(1000)
    line.put(1.0, bytes(100))  # takes a second
    line.clear()
    line.put(1.0, b"a")
    assert line.next_due() == pytest.approx(1.01)


def test_damage_is_of_three_kinds_and_of_the_given_share() -> None:
    data = b"a" * 30_000
    assert add_noise(data, 0.0, random.Random(1)) is data
    noisy = add_noise(data, 0.01, random.Random(1))
    assert 60 <= len(noisy) - noisy.count(b"a") <= 140  # a third of 300
    assert abs(len(noisy) - len(data)) < 60
    assert add_noise(data, 0.01, random.Random(1)) == noisy
    kinds = {len(add_noise(b"a", 1.0, random.Random(seed))) for seed in range(20)}
    assert kinds == {0, 1, 2}
