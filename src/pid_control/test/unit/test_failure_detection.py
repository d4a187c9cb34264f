"""Tests of the failures of a controller in a scenario."""

from typing import Optional
from unittest import mock

import pytest

from pid_control.judging.record import ENDED, RESTLESS, SILENT, WRITES_WITHOUT_END, Record
from pid_control.judging.scenarios import BY_NAME
from pid_control.runner.failure_detection import BusyDetector, completed, failure_of
from pid_control.runner.judging_errors import BusyMachineError, JudgingError


def test_busy_detector_blames_the_controller_or_the_machine(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    now, spent = [0.0], [0.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    detector = BusyDetector(lambda: spent[0])
    for is_idle, at, used in ((False, 0.0, 0.0), (True, 20.0, 9.0), (False, 40.0, 10.0)):
        now[0], spent[0] = at, used
        detector.update(is_idle)
        assert not detector.is_its_own()
    now[0], spent[0] = 60.0, 12.0
    detector.update(False)
    assert not detector.is_its_own()
    spent[0] = 13.5  # more than 3 s since it was idle
    assert detector.is_its_own()
    spent[0], now[0] = 12.0, 71.0
    says = "^this machine is too busy: the controller gets no processor time$"
    with pytest.raises(BusyMachineError, match=says):
        detector.is_its_own()
    now[0] = 69.0  # 29 s since it was idle
    assert not detector.is_its_own()
    detector.update(True)
    spent[0] = 99.0
    assert not detector.is_its_own()


def test_flood_with_idle_moments_is_computing_without_a_pause() -> None:
    spent = [0.0]
    detector = BusyDetector(lambda: spent[0])
    for step in range(200):
        spent[0] += 0.02
        detector.update(is_idle=step % 5 > 0, is_flood=step % 25 == 0)
    assert detector.is_its_own()


def test_single_flood_of_a_busy_machine_is_forgotten() -> None:
    spent = [0.0]
    detector = BusyDetector(lambda: spent[0])
    for step in range(200):
        spent[0] += 0.02
        detector.update(is_idle=step > 0, is_flood=step == 0)
    assert not detector.is_its_own()


def test_failure_of_a_record_has_the_last_words_and_is_not_replaced() -> None:
    process = mock.Mock()
    process.last_words.return_value = "KeyError: 9"
    silent = Record(BY_NAME["ramp"])
    assert completed(silent, process)[1:3] == (SILENT, "KeyError: 9")
    assert completed(silent._replace(failure=ENDED), process)[1:3] == (ENDED, "KeyError: 9")
    answered = silent._replace(answers=[(1.9, 0.0)])
    assert completed(answered, process) == answered
    says = r"^the controller was killed \(signal 9\), maybe for lack of memory$"
    with pytest.raises(JudgingError, match=says):
        failure_of(mock.Mock(status=-9))


@pytest.mark.parametrize(
    "status, writes_without_end, is_restless, failure",
    [
        (None, False, False, ""),
        (None, False, True, RESTLESS),
        (None, True, True, WRITES_WITHOUT_END),
        (0, True, True, ENDED),
        (-15, False, False, ENDED),
    ],
)
def test_failure_of_a_controller_is_its_worst(
    status: Optional[int], writes_without_end: bool, is_restless: bool, failure: str
) -> None:
    process = mock.Mock(status=status, writes_without_end=writes_without_end)
    assert failure_of(process, is_restless) == failure
