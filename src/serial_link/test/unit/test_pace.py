"""How fast a line takes what is written."""

import pytest

from serial_link.host.pace import AHEAD_S, Pace


def test_frames_follow_each_other_without_a_gap_and_none_waits_long() -> None:
    pace, now = Pace(1000), 5.0  # a byte takes 10 ms
    assert pace.wait(now) == 0.0
    pace.written(now, 10)
    assert pace.wait(now) == pytest.approx(0.1 - AHEAD_S)
    now += pace.wait(now)
    pace.written(now, 10)
    assert pace.wait(now) == pytest.approx(0.1)  # the line goes on from the end of the first
    assert pace.wait(7.0) == 0.0
    pace.written(7.0, 1)
    assert pace.wait(7.0) == pytest.approx(0.01 - AHEAD_S)


def test_a_line_without_a_rate_is_always_free() -> None:
    pace = Pace(0)
    pace.written(1.0, 10_000)
    assert pace.wait(1.0) == 0.0
