#!/usr/bin/env python3
"""Tests of rare faults of judging gains: short time limit, and termination."""

import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

import rospkg
from helpers.left_behind import processes_of

from nodekit.testing.running import rosrun
from nodekit.testing.waiting import TIMEOUT_S, wait_until

TUNE = os.path.join(rospkg.RosPack().get_path("pid_control"), "scripts", "tune")
#: Judges in a separate process: a process becomes a node only once.
TOO_LONG = """
from pid_control.runner.gains_judgement import judge_gains
from pid_control.tuning.rules import Gains
for _, text in judge_gains([Gains("good", "a test", "PI", 0.08, 1.5)], time_limit=0.1):
    print(text)
"""


class TuneFaults(unittest.TestCase):
    """The judge's master is its own."""

    def test_judge_gains_time_limit_is_not_judged(self) -> None:
        command = [sys.executable, "-c", TOO_LONG]
        said = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout.decode()
        self.assertEqual(said.splitlines()[-1], "not judged: 0.1 s are over")

    def test_tune_termination_leaves_no_process(self) -> None:
        for number in (signal.SIGTERM, signal.SIGINT):
            with tempfile.TemporaryDirectory() as folder:
                model = pathlib.Path(folder) / "model.yaml"
                model.write_text("{system_param_K: 13.1, system_param_T: 0.1}")
                tune = subprocess.Popen(
                    [TUNE, str(model), "--judge"],
                    env={**os.environ, "TMPDIR": folder},
                    stderr=subprocess.PIPE,
                )
                self.addCleanup(tune.kill)
                wait_until(
                    lambda: any("controller.py" in line for line in processes_of(folder)),
                    lambda: f"no controller.py among {processes_of(folder)}",
                )
                tune.send_signal(number)
                _, errors = tune.communicate(timeout=TIMEOUT_S)
                self.assertEqual((tune.returncode, errors.decode()), (128 + number, ""))
                self.assertEqual(processes_of(folder), [])
                self.assertEqual(os.listdir(folder), ["model.yaml"])


if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rosrun("pid_control", "tune_faults", TuneFaults)
