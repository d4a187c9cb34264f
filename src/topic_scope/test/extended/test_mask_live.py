"""Command mask.py on a live graph."""

import csv
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

import roslib.packages
import rospy
from std_msgs.msg import Float64

PERIOD_S = 0.01


class MaskLive(unittest.TestCase):
    """Trace that follows its reference for a limited time."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.error = 0.0
        cls.publishers = [
            rospy.Publisher(f"/{name}", Float64, queue_size=10) for name in ("wanted", "actual")
        ]
        stop = threading.Event()
        thread = threading.Thread(target=cls.publish, args=(stop,))
        cls.addClassCleanup(thread.join)
        cls.addClassCleanup(stop.set)
        thread.start()

    @classmethod
    def publish(cls, stop: threading.Event) -> None:
        while not stop.wait(PERIOD_S):
            wanted, actual = cls.publishers
            wanted.publish(1.0)
            actual.publish(1.0 + cls.error)

    def check(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        return subprocess.run(
            [
                roslib.packages.find_node("topic_scope", "mask.py")[0],
                "/actual",
                "--around",
                "/wanted",
                *arguments,
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
            timeout=60,
            check=False,
        )

    def test_exit_status_reports_the_check(self) -> None:
        type(self).error = 0.05
        for seconds in ("2", "8", "30"):  # longer if a busy machine subscribes late
            inside = self.check("--value", "0.1", "--seconds", seconds)
            if inside.returncode != 2:
                break
        self.assertEqual(inside.returncode, 0, inside)
        self.assertRegex(inside.stdout, r"mask: \d{2,} samples inside, 0 outside")
        with tempfile.TemporaryDirectory() as folder:
            saved = Path(folder, "failure.csv")
            type(self).error = 0.2
            outside = self.check("--value", "0.1", "--seconds", "30", "--save", str(saved))
            self.assertEqual(outside.returncode, 1, outside)
            self.assertRegex(outside.stdout, r"at worst by 0\.1\b")
            with saved.open(newline="") as file:
                rows = list(csv.DictReader(file))
        self.assertTrue(any(row["/actual/data"] == "1.2" for row in rows), rows)

    def test_missing_trace_does_not_pass(self) -> None:
        nothing = self.check("--seconds", "1", "--around", "/missing/data")
        self.assertEqual(nothing.returncode, 2, nothing)
        self.assertIn("no sample could be checked: the topic does not exist yet", nothing.stderr)
