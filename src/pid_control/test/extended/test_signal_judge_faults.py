#!/usr/bin/env python3
"""Tests of courseworks with known flaws, judged on one private master."""

import contextlib
import pathlib
import tempfile
import unittest
from typing import List

from helpers.coursework_cases import COURSEWORKS, FAST, FLAWED, GOOD, Case, make
from nodekit.testing.running import rosrun
from pid_control.runner.default_limits import default_limits
from pid_control.runner.judging_errors import BusyMachineError, JudgingError
from pid_control.signal_judging.coursework_judgement import judge
from pid_control.signal_judging.scenarios import SCENARIO_METRICS, SCENARIOS
from pid_control.signal_runner.coursework_bench import CourseworkBench, find_request
from pid_control.verdicts.judgement import PASSED, Judgement
from pid_control.verdicts.reports import as_sentences

LIMITS = default_limits("judge_signals_limits.yaml", SCENARIO_METRICS)
PARAMETERS = ("parameters", "yaml")
#: Time of the machine is not the courseworks': a test takes as long as it needs.
LONG_S = 600.0


class TestSignalJudge(unittest.TestCase):
    """Courseworks on one master."""

    bench: CourseworkBench

    @classmethod
    def setUpClass(cls) -> None:
        cls.bench = CourseworkBench()

    @classmethod
    def tearDownClass(cls) -> None:
        cls.bench.close()

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def judged(self, package: pathlib.Path, scenarios: List[str]) -> Judgement:
        request = find_request([str(package)], scenarios)._replace(time_limit=LONG_S)
        while True:  # until the rostest's time limit
            with contextlib.suppress(BusyMachineError):
                evidence, reason = self.bench.run(request)
                return judge(evidence, LIMITS, scenarios, reason)

    def test_good_courseworks_pass(self) -> None:
        for name in GOOD:
            # Changes of one parameter after the other take most of the time: once is enough.
            is_whole = name == "wave_loops"
            scenarios = [one for one in SCENARIOS if is_whole or one not in PARAMETERS]
            with self.subTest(name):
                judgement = self.judged(COURSEWORKS / name, scenarios)
                self.assertEqual(judgement.verdict, PASSED, as_sentences(judgement))

    def test_loop_faster_than_the_steps_keeps_its_rate(self) -> None:
        judgement = self.judged(make(FAST, self.folder), list(FAST.scenarios))
        self.assertEqual(judgement.verdict, PASSED, as_sentences(judgement))
        figures = {(one.scenario, one.metric): one.value for one in judgement.findings}
        self.assertAlmostEqual(figures["signal", "rate"] or 0.0, 250.0, delta=5.0)
        self.assertAlmostEqual(figures["signal", "frequency"] or 0.0, 2.5, delta=0.05)

    def test_flawed_courseworks_fail_with_their_cause(self) -> None:
        for case in FLAWED:
            with self.subTest(case.name):
                package = make(case, self.folder)
                for _ in range(3):  # a busy machine may hide flaws, and never adds one
                    judgement = self.judged(package, list(case.scenarios))
                    text = as_sentences(judgement)
                    self.assertLessEqual(set(judgement.flaws()), set(case.flaws), text)
                    if judgement.flaws() == list(case.flaws):
                        break
                self.assertEqual(judgement.flaws(), list(case.flaws), text)
                for sentence in case.says:
                    self.assertIn(sentence, text)

    def test_machine_clock_is_not_compared_with_a_simulated_clock(self) -> None:
        edits = [
            ("scripts/signal_generator.py", "import numpy", "import time as clock\n\nimport numpy"),
            ("scripts/signal_generator.py", "rate.sleep()", "clock.sleep(0.1)"),
        ]
        case = Case("time_sleep", "wave_loops", edits, (), (), ())
        with self.assertRaisesRegex(JudgingError, "it uses the machine's clock.*--real-time"):
            self.judged(make(case, self.folder), ["signal"])

    def test_time_of_the_machine_in_a_ros_loop_is_not_judged(self) -> None:
        edits = [
            ("scripts/signal_generator.py", "import numpy", "import time as clock\n\nimport numpy"),
            ("scripts/signal_generator.py", "rospy.get_time()", "clock.time()"),
        ]
        case = Case("time_time", "wave_loops", edits, (), (), ())
        with self.assertRaisesRegex(JudgingError, "it uses the machine's clock.*--real-time"):
            self.judged(make(case, self.folder), ["signal"])


if __name__ == "__main__":
    rosrun("pid_control", "signal_judge_faults", TestSignalJudge)
