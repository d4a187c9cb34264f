#!/usr/bin/env python3
"""Tests of the judgement of gains for ``tune``."""

import unittest

from nodekit.testing.running import rosrun
from pid_control.controller.pid import PI
from pid_control.judging.scenarios import BY_NAME
from pid_control.runner.gains_judgement import judge_gains
from pid_control.tuning.rules import Gains

GOOD = Gains("good", "a test", PI, 0.08, 1.5)
WEAK = Gains("weak", "a test", PI, 0.001, 0.01)


class GainsJudgementTest(unittest.TestCase):
    """Of all scenarios one, as each of four gains takes a quarter of a minute in all of them."""

    def test_judge_gains_judges_each_separately(self) -> None:
        ramp = [BY_NAME["ramp"]]
        said = {gains.method: text for gains, text in judge_gains([GOOD, WEAK], ramp)}
        self.assertEqual(said["good"], "passed: all 2 figures of 1 scenario")
        self.assertIn("ramp: mean |error|", said["weak"])
        self.assertTrue(said["weak"].endswith("failed: gains"), said["weak"])


if __name__ == "__main__":
    rosrun("pid_control", "gains_judgement", GainsJudgementTest)
