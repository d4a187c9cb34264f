#!/usr/bin/env python3
"""Test of the judge's causes with many correct controllers drawn at random."""

import unittest
from typing import Any

from hypothesis import given, settings
from laws import CORRECT, correct
from played import default_limits, play_all

from nodekit.testing.running import rosrun
from pid_control.judging.controller_judgement import judge
from pid_control.verdicts.reports import as_sentences

LIMITS = default_limits()


class RandomControllers(unittest.TestCase):
    """As the unit test of the same name, with more of them."""

    @settings(deadline=None, max_examples=20)
    @given(**CORRECT)
    def test_judge_correct_controllers_get_no_false_cause(self, period: float, **law: Any) -> None:
        judgement = judge(play_all(correct(**law), period), LIMITS)
        about_gains = {"gains", "chatter", "unexplained"}
        self.assertLessEqual(set(judgement.flaws()), about_gains, as_sentences(judgement))


if __name__ == "__main__":
    rosrun("pid_control", "random_controllers", RandomControllers)
