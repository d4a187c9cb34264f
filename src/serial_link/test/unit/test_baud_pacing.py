"""Pacing of frames by the baud rate."""

import pytest

from serial_link.host.baud_pacing import AHEAD_S, BaudPacer


def test_frames_are_sent_without_gap_or_backlog() -> None:
    pacer, now = BaudPacer(1000), 5.0  # a byte takes 10 ms
    assert pacer.delay(now) == 0.0
    pacer.record_write(now, 10)
    assert pacer.delay(now) == pytest.approx(0.1 - AHEAD_S)
    now += pacer.delay(now)
    pacer.record_write(now, 10)
    assert pacer.delay(now) == pytest.approx(0.1)  # the line goes on from the end of the first
    assert pacer.delay(7.0) == 0.0
    pacer.record_write(7.0, 1)
    assert pacer.delay(7.0) == pytest.approx(0.01 - AHEAD_S)


def test_a_line_without_a_rate_is_always_free() -> None:
    pacer = BaudPacer(0)
    pacer.record_write(1.0, 10_000)
    assert pacer.delay(1.0) == 0.0
