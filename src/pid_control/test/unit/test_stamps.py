"""Tests of stamps that follow, repeat, are missing, or restart."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pid_control.controller.stamps import FIRST, GAP, LATE, NEXT, RESTART, StampClassifier

LONGEST = 0.5


@pytest.mark.parametrize(
    "stamp, kind, interval",
    [
        (2.01, NEXT, 0.01),
        (2.5, NEXT, 0.5),
        (2.6, GAP, 0.0),
        (2.0, LATE, 0.0),
        (1.91, LATE, 0.0),
        (1.89, RESTART, 0.0),
        (0.0, RESTART, 0.0),
    ],
)
def test_classify_compares_with_previous_stamp(stamp: float, kind: str, interval: float) -> None:
    classifier = StampClassifier()
    assert classifier.classify(2.0, LONGEST) == (FIRST, 0.0)
    got = classifier.classify(stamp, LONGEST)
    assert got.kind == kind
    assert got.interval == pytest.approx(interval)


def test_classify_late_stamp_keeps_state() -> None:
    classifier = StampClassifier()
    classifier.classify(2.0, LONGEST)
    classifier.classify(1.95, LONGEST)
    assert classifier.classify(2.01, LONGEST).interval == pytest.approx(0.01)


@given(st.lists(st.floats(-1e6, 1e6)))
def test_classify_intervals_never_exceed_elapsed_time(stamps: list) -> None:
    classifier, begun, total = StampClassifier(), 0.0, 0.0
    for stamp in stamps:
        kind, interval = classifier.classify(stamp, LONGEST)
        assert 0.0 <= interval <= LONGEST
        if kind in (FIRST, RESTART):
            begun, total = stamp, 0.0
        if kind != LATE:
            total += interval
            assert total <= stamp - begun + 1e-6


def test_classify_early_restart_differs_from_late_message_with_long_timeout() -> None:
    stamps = StampClassifier()
    stamps.classify(1.0, 30.0)
    assert stamps.classify(0.95, 30.0).kind == LATE
    assert stamps.classify(0.001, 30.0).kind == RESTART
    assert stamps.classify(0.002, 30.0).kind == NEXT
