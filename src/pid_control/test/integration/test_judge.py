#!/usr/bin/env python3
"""Tests of the judge: diagnosis, batch runs, and nothing left behind."""

import csv
import os
import signal
from xml.etree import ElementTree

from helpers.judge_rig import CONTROLLERS, LONG_S, JudgeCase

from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until


class Judge(JudgeCase):
    """Errors in arguments are in the unit tests, rare faults in test/extended."""

    def test_judge_windup_is_reported_drawn_and_written(self) -> None:
        picture, table = self.folder / "windup.svg", self.folder / "windup.csv"
        files = ["--picture", picture, "--csv", table]
        limits = self.folder / "limits.yaml"
        limits.write_text("windup: {peak_input: 0.5}\n")
        xml = self.folder / "windup.xml"
        text = self.assert_judged(
            1,
            "the integral goes on growing while the output is limited; stop it there",
            *[*files, "--limits", limits, "--only", "windup"],
            *[CONTROLLERS / "flaw_windup.py", f"--gtest_output=xml:{xml}", "__name:=judge"],
        )
        self.assertIn("windup: largest |input| 1, at most 0.5", text)
        self.assertIn("the input is within -1 and 1, but beyond the limit for it", text)
        self.assertTrue(text.endswith("failed: no clamp, windup\n"), text)
        self.assertIn("windup", ElementTree.parse(str(picture)).getroot()[-1][0].text)
        self.assertIn('failed,"no clamp, windup"', table.read_text())
        suite = ElementTree.parse(str(xml)).getroot()
        self.assertEqual((suite.get("tests"), suite.get("failures")), ("1", "1"))

    def test_judge_launch_file_runs_one_node_with_its_parameters(self) -> None:
        """The course's launch file starts the motor and the set point as well."""
        gains = self.folder / "gains.yaml"
        gains.write_text("{kp: -0.05, ki: -1.0}\n")
        words = ["pid_control", "motor_control.launch", f"control_config:={gains}"]
        self.assert_judged(1, "failed: sign", "--only", "held", *words)

    def test_batch_with_broken_packages_writes_one_csv_and_one_page(self) -> None:
        self.make_package("anna", "flaw_windup.py")
        self.make_package("ben/ben_control", "flaw_crash_at_start.py")
        self.make_package("cleo")
        (self.folder / "class" / "cleo" / "scripts" / "Controller.py").touch()
        output = self.folder / "out"
        words = ["--output", output, "--only", "windup", "--class", self.folder / "class"]
        self.assert_judged(1, "anna: failed: the integral goes on growing", *words)
        with (output / "class.csv").open() as file:
            rows = {row["controller"]: row for row in csv.DictReader(file)}
        self.assertEqual(
            {name: (row["verdict"], row["flaws"]) for name, row in rows.items()},
            {
                "anna": ("failed", "windup"),
                "ben/ben_control": ("failed", "crash"),
                "cleo": ("not judged", ""),
            },
        )
        self.assertIn("no_such_module", rows["ben/ben_control"]["why"])
        self.assertEqual(
            rows["cleo"]["why"], "it has no controller.py; did you mean Controller.py?"
        )
        page = (output / "class.html").read_text()
        self.assertIn("<h1>3 controllers</h1><p>0 passed, 2 failed, 1 not judged</p>", page)
        self.assertIn('href="anna.svg"', page)
        self.assertIn("likely cause (windup)", (output / "anna.txt").read_text())
        self.assertTrue((output / "anna.svg").is_file())

    def test_judge_ctrl_c_ends_all_child_processes(self) -> None:
        judge = self.start_judge()
        self.wait_for_program("good_loop.py")
        os.killpg(judge.pid, signal.SIGINT)  # as a terminal does: to all in the foreground
        _, errors = judge.communicate(timeout=LONG_S)
        self.assertEqual((judge.returncode, errors), (130, ""))
        wait_until(lambda: not self.processes(), lambda: f"left behind: {self.processes()}")


if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rosrun("pid_control", "judge", Judge)
