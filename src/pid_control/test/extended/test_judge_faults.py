#!/usr/bin/env python3
"""Tests of the judge: class runs, launch files, another clock, and Ctrl-C at any time."""

import csv
import os
import signal
import subprocess

from helpers.judge_rig import CONTROLLERS, JUDGE, LONG_S, JudgeCase

from nodekit.testing.running import rosrun
from nodekit.testing.waiting import wait_until


class JudgeFaults(JudgeCase):
    """Each test has its own folder."""

    def test_judge_launch_file_runs_one_node_with_its_parameters(self) -> None:
        """The course's launch file starts the motor and the set point as well."""
        gains = self.folder / "gains.yaml"
        gains.write_text("{kp: -0.05, ki: -1.0}\n")
        words = ["pid_control", "motor_control.launch", f"control_config:={gains}"]
        self.assert_judged(1, "failed: sign", "--only", "held", *words)

    def test_judge_package_in_a_namespace_with_other_types_is_connected(self) -> None:
        self.make_package("anna", "float32_topics.py")
        package = self.folder / "class" / "anna"
        (package / "loop.launch").write_text(
            '<launch><node ns="left" pkg="anna" type="controller.py" name="mine"/></launch>'
        )
        words = ["--only", "held", package / "scripts" / "controller.py"]
        report = self.assert_judged(0, "passed: all", *words)
        self.assertIn("its parameters and names for /left/mine are used", report)
        self.assertIn("motor_input is std_msgs/Float32", report)
        self.assertNotIn("[WARN]", report)

    def test_batch_with_broken_packages_writes_one_csv_and_one_page(self) -> None:
        """One of them has the name of the judge's own."""
        self.make_package("pid_control", "flaw_windup.py")
        self.make_package("ben/ben_control", "flaw_crash_at_start.py")
        self.make_package("cleo")
        (self.folder / "class" / "cleo" / "scripts" / "Controller.py").touch()
        output = self.folder / "out"
        words = ["--output", output, "--only", "windup", "--class", self.folder / "class"]
        self.assert_judged(1, "pid_control: failed: the integral keeps growing", *words)
        with (output / "class.csv").open() as file:
            rows = {row["controller"]: row for row in csv.DictReader(file)}
        self.assertEqual(
            {name: (row["verdict"], row["flaws"]) for name, row in rows.items()},
            {
                "ben/ben_control": ("failed", "crash"),
                "cleo": ("not judged", ""),
                "pid_control": ("failed", "windup"),
            },
        )
        self.assertIn("no_such_module", rows["ben/ben_control"]["why"])
        self.assertEqual(
            rows["cleo"]["why"], "it has no controller.py; did you mean Controller.py?"
        )
        page = (output / "class.html").read_text()
        self.assertIn("<h1>3 controllers</h1><p>0 passed, 2 failed, 1 not judged</p>", page)
        self.assertIn('href="pid_control.svg"', page)
        self.assertIn("likely cause (windup)", (output / "pid_control.txt").read_text())
        self.assertTrue((output / "pid_control.svg").is_file())

    def test_judge_time_time_is_not_judged(self) -> None:
        says = "not judged: it uses the machine's clock (time.time(), time.sleep())"
        controller = CONTROLLERS / "flaw_time_time.py"
        for _ in range(3):
            done = self.judge("--only", "held,rate", controller)
            if done.returncode == 125:
                break
            # On a busy machine its time steps are too irregular for the figure.
            self.assertRegex(done.stdout, "integrated time during pauses +- ")
        self.assertIn(says, done.stdout)
        self.assertEqual(done.returncode, 125)

    def test_judge_ctrl_c_ends_all_child_processes(self) -> None:
        judge = self.start_judge()
        self.wait_for_program("good_loop.py")
        os.killpg(judge.pid, signal.SIGINT)  # as a terminal does: to all in the foreground
        _, errors = judge.communicate(timeout=LONG_S)
        self.assertEqual((judge.returncode, errors), (130, ""))
        wait_until(lambda: not self.processes(), lambda: f"left behind: {self.processes()}")

    def test_judge_ctrl_c_during_master_start_ends_it(self) -> None:
        judge = self.start_judge()
        self.wait_for_program("rosmaster")
        os.killpg(judge.pid, signal.SIGINT)  # as a terminal does: to all in the foreground
        _, errors = judge.communicate(timeout=LONG_S)
        self.assertEqual((judge.returncode, errors), (130, ""))
        wait_until(lambda: not self.processes(), lambda: f"left behind: {self.processes()}")

    def test_judge_ctrl_c_during_import_prints_no_traceback(self) -> None:
        environment = self.environment()
        # numpy makes an ImportError of Ctrl-C in the middle of its import.
        (self.folder / "numpy").mkdir()
        (self.folder / "numpy" / "__init__.py").write_text(
            "import os, signal\n"
            "try:\n"
            "    os.kill(os.getpid(), signal.SIGINT)\n"
            "    signal.sigpending()\n"
            "except KeyboardInterrupt:\n"
            "    raise ImportError('numpy.core') from None\n"
        )
        environment["PYTHONPATH"] = f"{self.folder}:{environment['PYTHONPATH']}"
        judge = subprocess.run(
            [str(JUDGE), str(CONTROLLERS / "good_loop.py")],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
            timeout=LONG_S,
        )
        self.assertEqual((judge.returncode, judge.stdout, judge.stderr), (130, "", ""))


if __name__ == "__main__":
    # A program started in the background ignores Ctrl-C, and so would all that it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rosrun("pid_control", "judge_faults", JudgeFaults)
