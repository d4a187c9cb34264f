"""Tests of what counts as a failure of a running controller, and which of two is named."""

import types

from pid_control.judging.record import RESTLESS, WRITES_WITHOUT_END
from pid_control.runner.failure_detection import BusyDetector, failure_of

TALKATIVE = types.SimpleNamespace(status=None, writes_without_end=True)


def spending(*times):
    """Return a detector whose controller has used these processor times [s], one after another."""
    left = iter(times)
    return BusyDetector(lambda: next(left))


def test_loop_without_a_pause_that_logs_is_restless_whichever_is_seen_first():
    detector = spending(0.0, 1.0, 3.5)
    detector.update(False)
    assert failure_of(TALKATIVE, detector) == ""
    detector.update(False)
    assert failure_of(TALKATIVE, detector) == RESTLESS


def test_output_without_end_is_named_once_the_controller_rests():
    detector = spending(0.0, 1.0)
    detector.update(False)
    assert failure_of(TALKATIVE, detector) == ""
    detector.update(True)
    assert failure_of(TALKATIVE, detector) == WRITES_WITHOUT_END
    assert failure_of(TALKATIVE) == WRITES_WITHOUT_END
