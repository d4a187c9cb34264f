"""Tests of the search for missing messages in the bag of a long run."""

import pathlib

import numpy as np
import pytest
import rosbag
import rospy
from std_msgs.msg import Float32

from basic_comms.msg import signal_msg
from ci.endurance import run_record

TIMES = np.arange(4000) / run_record.RATE
ANSWERS = 1.0 + np.cos(TIMES)


def found(folder: pathlib.Path, times: "np.ndarray", answers: "np.ndarray") -> "list[str]":
    """Return the failed checks of a bag with these samples and answers."""
    with rosbag.Bag(str(folder / "bag"), "w") as bag:
        for number, time_x in enumerate(times):
            bag.write("/signal", signal_msg(time_x=time_x), rospy.Time(1.0 + number / 1000.0))
        for number, answer in enumerate(answers):
            bag.write("/proc_signal", Float32(answer), rospy.Time(1.0 + number / 1000.0))
    return [check.what for check in run_record.check_bag(folder / "bag") if not check.passed]


@pytest.mark.parametrize("late", [0, 1, 7, 399])
def test_either_topic_may_begin_before_the_other(tmp_path: pathlib.Path, late: int) -> None:
    assert found(tmp_path, TIMES[late:], ANSWERS) == []
    assert found(tmp_path, TIMES, ANSWERS[late:]) == []


@pytest.mark.parametrize("place", [300, 2000, 3999])
def test_a_missing_answer_is_found(tmp_path: pathlib.Path, place: int) -> None:
    what = "answers missing, or not to their samples"
    assert found(tmp_path, TIMES, np.delete(ANSWERS, place)) == [what]


def test_a_missing_or_repeated_sample_is_found(tmp_path: pathlib.Path) -> None:
    what = "missing or repeated in the bag"
    assert what in found(tmp_path, np.delete(TIMES, 2000), ANSWERS)
    assert what in found(tmp_path, np.insert(TIMES, 2000, TIMES[2000]), ANSWERS)


def test_a_bag_with_few_answers_falls_short(tmp_path: pathlib.Path) -> None:
    assert "answers compared" in found(tmp_path, TIMES, ANSWERS[-100:])
