#!/usr/bin/env python3
"""Record /signal and /proc_signal of a running cw1.launch and draw the picture of the README.

    ./ci/exec docs/make_readme_picture.py

It starts a master of its own, sets two parameters while the nodes run, and
writes docs/images/cw1.svg.
"""

import os
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import List, Tuple

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import rosgraph  # noqa: E402
import rospy  # noqa: E402
from basic_comms.msg import signal_msg  # noqa: E402
from std_msgs.msg import Float32  # noqa: E402

PICTURE = Path(__file__).resolve().parent / "images" / "cw1.svg"
CHANGES = [
    (2.0, "/signal_generator/frequency", 15.0),
    (4.0, "/process/amplitude_scale", 1.0),
]
LENGTH_S = 6.0
BLUE, ORANGE, GREY = "#2166ac", "#d6604d", "#777777"


class Recording:
    """What arrived on the two topics, and when."""

    def __init__(self) -> None:
        self.signal: List[Tuple[float, float]] = []
        self.proc_signal: List[Tuple[float, float]] = []
        rospy.Subscriber(
            "signal",
            signal_msg,
            lambda heard: self.signal.append((time.monotonic(), heard.signal_y)),
            tcp_nodelay=True,
        )
        rospy.Subscriber(
            "proc_signal",
            Float32,
            lambda heard: self.proc_signal.append((time.monotonic(), heard.data)),
            tcp_nodelay=True,
        )


def record() -> Tuple[Recording, float]:
    """Record while the parameters change.

    :returns: the recording, and the moment that is zero on the picture
    """
    rospy.init_node("recorder")
    recording = Recording()
    while not recording.proc_signal:
        time.sleep(0.01)
    start = time.monotonic() + 0.5
    for moment, name, value in CHANGES:
        time.sleep(start + moment - time.monotonic())
        rospy.set_param(name, value)
    time.sleep(start + LENGTH_S - time.monotonic())
    return recording, start


def draw(recording: Recording, start: float) -> None:
    """Draw what was recorded, with a line where a parameter was set."""
    plt.rcParams.update({"svg.hashsalt": "basic_comms", "font.size": 9})
    figure, axes = plt.subplots(figsize=(8.0, 3.0))
    for label, colour, samples in (
        ("/signal", BLUE, recording.signal),
        ("/proc_signal", ORANGE, recording.proc_signal),
    ):
        times = [moment - start for moment, _ in samples]
        axes.plot(times, [value for _, value in samples], color=colour, label=label)
    for moment, name, value in CHANGES:
        axes.axvline(moment, color=GREY, linestyle="--", linewidth=1.0)
        command = "rosparam set %s %g" % (name, value)
        axes.text(moment + 0.03, -2.75, command, color=GREY, family="monospace", fontsize=6.5)
    axes.set_xlim(0.0, LENGTH_S)
    axes.set_ylim(-3.0, 4.9)
    axes.set_xlabel("time, s")
    axes.legend(loc="upper left", ncol=2, frameon=False)
    axes.spines["top"].set_visible(False)
    axes.spines["right"].set_visible(False)
    figure.tight_layout()
    figure.savefig(PICTURE, metadata={"Date": None})


def main() -> None:
    """Run the launch file on a master of its own, record, draw."""
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        os.environ["ROS_MASTER_URI"] = "http://localhost:%d" % probe.getsockname()[1]
    command = ["roslaunch", "basic_comms", "cw1.launch", "signal_rate:=100"]
    launch = subprocess.Popen(command, stdout=sys.stderr)
    try:
        while not rosgraph.is_master_online() and launch.poll() is None:
            time.sleep(0.1)
        draw(*record())
    finally:
        launch.terminate()
        launch.wait()


if __name__ == "__main__":
    main()
