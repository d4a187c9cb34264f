#!/usr/bin/env python3
"""Record /signal and /proc_signal of a running cw1.launch and draw the picture of the README.

    ./ci/exec docs/make_readme_picture.py

It starts a master of its own, sets two parameters while the nodes run, and
writes docs/images/cw1.svg.
"""

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import List

import matplotlib

from nodekit.testing.processes import free_port

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import rosgraph  # noqa: E402
import rospy  # noqa: E402
from std_msgs.msg import Float32  # noqa: E402
from std_srvs.srv import SetBool  # noqa: E402

from basic_comms.msg import signal_msg  # noqa: E402

PICTURE = Path(__file__).resolve().parent / "images" / "cw1.svg"
CHANGES = [
    (2.0, "/signal_generator/frequency", 15.0),
    (4.0, "/process/amplitude_scale", 1.0),
]
LENGTH_S = 6.0
BLUE, ORANGE, GREY = "#2166ac", "#d6604d", "#777777"


class Recording:
    """The samples of the two topics, and the times at which parameters were set."""

    def __init__(self) -> None:
        self.signal: List[signal_msg] = []
        self.proc_signal: List[Float32] = []
        self.changes: List[float] = []
        rospy.Subscriber("signal", signal_msg, self.signal.append)
        rospy.Subscriber("proc_signal", Float32, self.proc_signal.append)

    def keep_what_ran(self) -> None:
        """Leave the samples made while the signal ran, each with its answer.

        Process answers every sample, in order: so the last answers belong to the last samples.
        """
        signal = [sample for sample in self.signal if sample.amplitude > 0.0]
        answers = self.proc_signal
        while answers[-1].data == 0.0:
            answers = answers[:-1]
        both = min(len(signal), len(answers))
        self.signal, self.proc_signal = signal[-both:], answers[-both:]


def record() -> Recording:
    """Record while the parameters change."""
    rospy.init_node("recorder")
    recording = Recording()
    while not (recording.signal and recording.proc_signal):
        time.sleep(0.01)
    start = time.monotonic() + 0.5
    for moment, name, value in CHANGES:
        time.sleep(start + moment - time.monotonic())
        recording.changes.append(recording.signal[-1].time_x)
        rospy.set_param(name, value)
    time.sleep(start + LENGTH_S - time.monotonic())
    rospy.ServiceProxy("/signal_generator/enable", SetBool)(False)
    while recording.signal[-1].amplitude > 0.0 or recording.proc_signal[-1].data != 0.0:
        time.sleep(0.01)
    recording.keep_what_ran()
    return recording


def draw(recording: Recording) -> None:
    """Draw what was recorded, with a line where a parameter was set."""
    plt.rcParams.update({"svg.hashsalt": "basic_comms", "font.size": 9})
    figure, axes = plt.subplots(figsize=(8.0, 3.0))
    start = recording.changes[0] - CHANGES[0][0]
    times = [sample.time_x - start for sample in recording.signal]
    samples = [sample.signal_y for sample in recording.signal]
    axes.plot(times, samples, color=BLUE, label="/signal")
    answers = [answer.data for answer in recording.proc_signal]
    axes.plot(times, answers, color=ORANGE, label="/proc_signal")
    for moment, (_, name, value) in zip(recording.changes, CHANGES):
        axes.axvline(moment - start, color=GREY, linestyle="--", linewidth=1.0)
        command = f"rosparam set {name} {value:g}"
        axes.text(
            moment - start + 0.03, -2.75, command, color=GREY, family="monospace", fontsize=6.5
        )
    axes.set_xlim(0.0, LENGTH_S)
    axes.set_ylim(-3.0, 4.9)
    axes.set_xlabel("time_x, s")
    axes.legend(loc="upper left", ncol=2, frameon=False)
    axes.spines["top"].set_visible(False)
    axes.spines["right"].set_visible(False)
    figure.tight_layout()
    figure.savefig(PICTURE, metadata={"Date": None})


def main() -> None:
    """Run the launch file on a master of its own, record, draw."""
    os.environ["ROS_MASTER_URI"] = f"http://localhost:{free_port()}"
    command = ["roslaunch", "basic_comms", "cw1.launch", "signal_rate:=100"]
    launch = subprocess.Popen(command, stdout=sys.stderr)
    try:
        while not rosgraph.is_master_online() and launch.poll() is None:
            time.sleep(0.1)
        draw(record())
    finally:
        launch.terminate()
        launch.wait()


if __name__ == "__main__":
    main()
