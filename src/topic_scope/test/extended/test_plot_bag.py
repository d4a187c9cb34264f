"""plot_bag.py against rosbag, on a bag recorded by cw1.launch."""

import csv
import os
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Dict, List
from unittest import mock

import rosbag
import roslib.packages
from std_msgs.msg import Float32

from nodekit.testing.message_recorder import MessageRecorder
from nodekit.testing.launching import launched
from nodekit.testing.waiting import wait_until

FIELDS = ["/lab/signal/signal_y", "/lab/signal/time_x", "/lab/proc_signal/data"]


class PlotBag(unittest.TestCase):
    """Bag of the real nodes, recorded once."""

    folder: Path
    bag: Path

    @classmethod
    def setUpClass(cls) -> None:
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        with mock.patch.dict(os.environ, PWD=folder.name):
            with launched("basic_comms cw1.launch ns:=lab record:=true signal_rate:=100") as launch:
                for node, topic, *subscribers in (
                    ("/lab/signal_generator", "/lab/signal", "/lab/process", "/lab/record"),
                    ("/lab/process", "/lab/proc_signal", "/lab/record"),
                ):
                    launch.graph.wait_for_publishers(topic, node)
                    launch.graph.wait_until_heard(node, topic, *subscribers)
                ear = MessageRecorder("/lab/proc_signal", Float32)
                wait_until(lambda: len(ear.messages()) > 100, lambda: "there is no signal")
        # A bag has this name only when it is complete.
        (cls.bag,) = cls.folder.glob("cw1_*.bag")

    def plot(self, *arguments: str) -> None:
        subprocess.run(
            [roslib.packages.find_node("topic_scope", "plot_bag.py")[0], str(self.bag), *arguments],
            cwd=str(self.folder),
            check=True,
        )

    def rows(self, name: str) -> List[Dict[str, str]]:
        with (self.folder / name).open(newline="") as file:
            return list(csv.DictReader(file))

    def read_by_rosbag(self) -> List[Dict[str, str]]:
        """Return the expected rows of the CSV file."""
        rows = []
        with rosbag.Bag(str(self.bag)) as bag:
            begin = None
            for topic, message, time in bag.read_messages():
                begin = begin or time
                row = dict.fromkeys(FIELDS, "")
                for field in FIELDS:
                    if field.startswith(topic + "/"):
                        row[field] = repr(getattr(message, field[len(topic) + 1 :]))
                row["time"] = f"{(time - begin).secs}.{(time - begin).nsecs:09}"
                rows.append(row)
        return rows

    def test_csv_equals_the_messages_of_rosbag(self) -> None:
        self.plot(*FIELDS, "-o", "out.csv")
        rows = self.rows("out.csv")
        self.assertEqual(rows, self.read_by_rosbag())
        self.assertGreater(len([row for row in rows if row[FIELDS[0]]]), 50)
        self.assertGreater(len([row for row in rows if row[FIELDS[2]]]), 50)

    def test_range_of_time(self) -> None:
        rows = [row for row in self.read_by_rosbag() if row[FIELDS[2]]]
        # By their count: on a busy machine there may be no message for a while.
        start, end = rows[10]["time"], rows[40]["time"]
        limits = ["--start", f"{float(start):.3f}", "--end", f"{float(end):.3f}"]
        self.plot("/lab/proc_signal", "-o", "part.csv", *limits)
        expected = [
            {"time": row["time"], FIELDS[2]: row[FIELDS[2]]}
            for row in rows
            if float(limits[1]) <= float(row["time"]) <= float(limits[3])
        ]
        self.assertGreater(len(expected), 10)
        self.assertEqual(self.rows("part.csv"), expected)

    def test_a_picture(self) -> None:
        self.plot(*FIELDS, "-o", "out.png")
        content = (self.folder / "out.png").read_bytes()
        self.assertTrue(content.startswith(b"\x89PNG"))
        self.assertGreater(len(content), 5000)
