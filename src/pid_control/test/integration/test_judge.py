#!/usr/bin/env python3
"""The judge names what is wrong, refuses what cannot be judged, and leaves nothing behind."""

import csv
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import unittest
from typing import Dict, List
from xml.etree import ElementTree

import rospkg
from left_behind import processes_of

from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until

PACKAGE = pathlib.Path(rospkg.RosPack().get_path("pid_control"))
CONTROLLERS = PACKAGE / "test" / "controllers"
JUDGE = PACKAGE / "scripts" / "judge"
LONG_S = 120.0


class Judge(unittest.TestCase):
    """Each test has a folder of its own, also for what the judge writes in between."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def environment(self) -> Dict[str, str]:
        return {**os.environ, "TMPDIR": str(self.folder)}

    def judge(self, *words: object) -> "subprocess.CompletedProcess[str]":
        """Judge, to the end, and make sure that nothing is left behind."""
        done = subprocess.run(
            [str(JUDGE), *map(str, words)],
            env=self.environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            universal_newlines=True,
            timeout=LONG_S,
        )
        self.assertEqual(self.processes(), [], done.stdout)
        self.assertEqual(list(self.folder.glob("judge-*")), [], done.stdout)
        return done

    def processes(self) -> List[str]:
        """Return all processes that the judge of this test has started and that still run."""
        return processes_of(str(self.folder))

    def assert_judged(self, status: int, says: str, *words: object) -> str:
        """Judge, and compare the exit status and a line of what is said."""
        done = self.judge(*words)
        self.assertIn(says, done.stdout)
        self.assertEqual(done.returncode, status, done.stdout)
        self.assertNotIn("Traceback", done.stdout)
        return done.stdout

    def test_windup_is_named_drawn_and_written_down(self) -> None:
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
        self.assertTrue(text.endswith("failed: windup, no clamp\n"), text)
        self.assertIn("windup", ElementTree.parse(str(picture)).getroot()[-1][0].text)
        self.assertIn('failed,"windup, no clamp"', table.read_text())
        suite = ElementTree.parse(str(xml)).getroot()
        self.assertEqual((suite.get("tests"), suite.get("failures")), ("1", "1"))

    def test_whoever_goes_by_time_time_is_not_judged(self) -> None:
        says = "not judged: it goes by the machine's clock (time.time(), time.sleep())"
        self.assert_judged(125, says, CONTROLLERS / "flaw_time_time.py")

    def test_one_node_of_a_launch_file_with_its_parameters(self) -> None:
        """The course's launch file starts the motor and the set point as well."""
        gains = self.folder / "gains.yaml"
        gains.write_text("{kp: -0.05, ki: -1.0}\n")
        words = ["pid_control", "motor_control.launch", f"control_config:={gains}"]
        self.assert_judged(1, "failed: sign", "--only", "held", *words)

    def make_package(self, name: str, controller: str = "") -> None:
        """Make a package of a class."""
        scripts = self.folder / "class" / name / "scripts"
        scripts.mkdir(parents=True)
        (scripts.parent / "package.xml").write_text(f"<package><name>{name}</name></package>")
        for file in [controller, "student.py"] if controller else []:
            shutil.copy(str(CONTROLLERS / file), str(scripts))
        if controller:
            (scripts / controller).rename(scripts / "controller.py")

    def test_a_class_with_broken_ones_gets_one_file_and_one_page(self) -> None:
        self.make_package("anna", "flaw_windup.py")
        self.make_package("ben/ben_control", "flaw_crash_at_start.py")
        self.make_package("cleo")
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
        self.assertEqual(rows["cleo"]["why"], "it has no controller.py")
        page = (output / "class.html").read_text()
        self.assertIn("<h1>3 controllers</h1><p>0 passed, 2 failed, 1 not judged</p>", page)
        self.assertIn('href="anna.svg"', page)
        self.assertIn("likely cause (windup)", (output / "anna.txt").read_text())
        self.assertTrue((output / "anna.svg").is_file())

    def test_a_package_of_a_class_may_be_called_as_the_judges_own(self) -> None:
        self.make_package("pid_control", "flaw_windup.py")
        words = ["--output", self.folder, "--only", "windup", "--class", self.folder / "class"]
        says = "pid_control: failed: the integral goes on growing"
        self.assert_judged(1, says, *words)

    def test_what_cannot_be_judged_is_refused_by_name(self) -> None:
        wrong = self.folder / "wrong.yaml"
        wrong.write_text("steps: {overshot: 5}\n")
        not_executable = self.folder / "controller.py"
        not_executable.write_text("")
        simulated = self.folder / "simulated.launch"
        simulated.write_text(
            """<launch>
              <param name="/use_sim_time" value="true"/>
              <node pkg="pid_control" type="controller.py" name="controller"/>
            </launch>"""
        )
        refused = {
            f"{simulated} /controller: it sets /use_sim_time": ["--real-plant", simulated],
            f"{wrong}: steps: overshot: not measured there": ["--limits", wrong, "x"],
            "nowhere.yaml: No such file": ["--limits", "nowhere.yaml", "x"],
            "what? a package and a name in it, or a path": [],
            "there is no package no_such_package": ["no_such_package", "controller.py"],
            "there is no nothing.py in the package pid_control": ["pid_control", "nothing.py"],
            "there is no file a/b.py": ["a/b.py"],
            f"is not executable: chmod +x {not_executable}": [not_executable],
            "no scenario 'stairs'; there are held, rate": ["--only", "stairs", "x"],
            "'0' must be from 1 to 3600 s": ["--time-limit", "0", "x"],
            "has no node motor; its nodes are /system": [
                *["--node", "motor", "pid_control", "motor_control.launch"]
            ],
            "'judged.png' does not end in .svg": ["--picture", "judged.png", "x"],
            "'fast' must be above 0 and at most 1e+06 rad/s": ["--full-speed", "fast", "x"],
            "--full-speed is that of a --real-plant": ["--full-speed", "9", "x", "y"],
            "there is no folder nowhere": ["--class", "nowhere"],
            f"no package in {self.folder}": ["--class", self.folder],
            "are not for a --class": ["--class", self.folder, "--csv", "x"],
            f"{self.folder}/no/x.csv: No such": ["--csv", self.folder / "no" / "x.csv", "x", "y"],
            f"judge: {self.folder}: Is a directory": ["--csv", self.folder, "x", "y"],
            f"{self.folder}/no/x.svg: No such": [
                *["--picture", self.folder / "no" / "x.svg", CONTROLLERS / "good_loop.py"]
            ],
            "is no built workspace": ["--workspace", self.folder, "x", "controller.py"],
        }
        for says, words in refused.items():
            with self.subTest(says):
                self.assert_judged(125, says, *words)

    def test_ctrl_c_ends_it_and_all_that_it_has_started(self) -> None:
        # A child that was just forked has its parent's command line until it runs a program.
        for program in ("rosmaster", "good_loop.py"):
            judge = subprocess.Popen(
                [str(JUDGE), str(CONTROLLERS / "good_loop.py")],
                env=self.environment(),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                start_new_session=True,
            )
            self.addCleanup(judge.kill)
            wait_until(
                lambda: any(program in one and str(JUDGE) not in one for one in self.processes()),
                lambda: f"no {program} among {self.processes()}",
            )
            os.killpg(judge.pid, signal.SIGINT)  # as a terminal does: to all in the foreground
            _, errors = judge.communicate(timeout=LONG_S)
            self.assertEqual((judge.returncode, errors.decode()), (130, ""))
            wait_until(lambda: not self.processes(), lambda: f"left behind: {self.processes()}")

    def test_ctrl_c_while_it_is_imported_ends_it_without_a_traceback(self) -> None:
        judge = subprocess.Popen(
            [str(JUDGE), str(CONTROLLERS / "good_loop.py")],
            env={**self.environment(), "PYTHONPROFILEIMPORTTIME": "1"},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            universal_newlines=True,
        )
        self.addCleanup(judge.kill)
        assert judge.stderr is not None
        for line in judge.stderr:  # each names a module that has been imported
            if line.split()[-1] == "pid_control.files":
                break
        judge.send_signal(signal.SIGINT)
        _, errors = judge.communicate(timeout=LONG_S)
        self.assertNotIn("Traceback", errors)
        self.assertNotIn("rospy.core", errors)  # it was not too late
        self.assertEqual(judge.returncode, 130)


if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rosrun("pid_control", "judge", Judge)
