"""Test rig for the judge: a temporary folder, and a check that nothing is left behind."""

import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest
from typing import Dict, List

import rospkg

from helpers.left_behind import processes_of
from nodekit.testing.waiting import wait_until

PACKAGE = pathlib.Path(rospkg.RosPack().get_path("pid_control"))
CONTROLLERS = PACKAGE / "test" / "controllers"
JUDGE = PACKAGE / "scripts" / "judge"
LONG_S = 120.0


class JudgeCase(unittest.TestCase):
    """Test case with a folder for each test, also for what the judge writes in between.

    :ivar program: the judge
    """

    program = JUDGE

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def environment(self) -> Dict[str, str]:
        """Return the environment by which processes of this test are found."""
        return {**os.environ, "TMPDIR": str(self.folder)}

    def judge(self, *words: object) -> "subprocess.CompletedProcess[str]":
        """Judge, to the end, and make sure that nothing is left behind."""
        done = subprocess.run(
            [str(self.program), *map(str, words)],
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
        """Judge, and compare the exit status and a line of the output."""
        done = self.judge(*words)
        self.assertIn(says, done.stdout)
        self.assertEqual(done.returncode, status, done.stdout)
        self.assertNotIn("Traceback", done.stdout)
        return done.stdout

    def start_judge(self) -> "subprocess.Popen[str]":
        """Start to judge a good controller, in a new session."""
        judge = subprocess.Popen(
            [str(JUDGE), str(CONTROLLERS / "good_loop.py")],
            env=self.environment(),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            universal_newlines=True,
            start_new_session=True,
        )
        self.addCleanup(judge.kill)
        return judge

    def wait_for_program(self, program: str) -> None:
        """Wait until the judge has started a program."""
        # A child that was just forked has its parent's command line until it runs a program.
        wait_until(
            lambda: any(program in one and str(JUDGE) not in one for one in self.processes()),
            lambda: f"no {program} among {self.processes()}",
        )

    def make_package(self, name: str, controller: str = "") -> None:
        """Make a package of a class."""
        scripts = self.folder / "class" / name / "scripts"
        scripts.mkdir(parents=True)
        (scripts.parent / "package.xml").write_text(f"<package><name>{name}</name></package>")
        for file in [controller, "student.py"] if controller else []:
            shutil.copy(str(CONTROLLERS / file), str(scripts))
        if controller:
            (scripts / controller).rename(scripts / "controller.py")
