"""Tests of the times of samples."""

from typing import List, Optional
from unittest import mock

import pytest

from pid_control.msg import motor_output
from pid_control.recording.samples import Samples, stamp_of


def times_of(stamps: List[Optional[float]], heard: List[float]) -> List[float]:
    samples = Samples()
    for stamp, moment in zip(stamps, heard):
        samples.add(moment, stamp, 0.0)
    return samples.times().tolist()


def test_times_late_arrivals_use_stamps() -> None:
    assert times_of([0.0, 1.0, 2.0], [100.5, 101.25, 102.75]) == [100.25, 101.25, 102.25]
    assert times_of([0.0], [100.5]) == [100.5]


@pytest.mark.parametrize(
    "stamps", [[0.0, 1.0, 1.0], [2.0, 1.0, 3.0], [0.0, float("nan"), 1.0], [0.0, None, 1.0]]
)
def test_times_stamps_that_do_not_increase_are_ignored(stamps: List[Optional[float]]) -> None:
    assert times_of(stamps, [5.0, 6.0, 7.0]) == [5.0, 6.0, 7.0]


def test_stamp_is_the_field_time() -> None:
    assert stamp_of(motor_output(1.0, 2.5, "")) == 2.5
    assert stamp_of(object()) is None
    assert stamp_of(mock.Mock(time=5)) is None  # not the course's, but a time of another type
