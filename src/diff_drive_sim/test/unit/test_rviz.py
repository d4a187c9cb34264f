"""Rviz's display of the robot on a virtual screen; only if rviz is installed."""

import os
import signal
import struct
import subprocess
from pathlib import Path
from typing import Dict, Iterator

import numpy
import pytest

from nodekit.testing.processes import Master
from nodekit.testing.waiting import wait_until

#: Some colours of the picture: the laser's points, the sunny side of a box and of the robot.
COLOURS = {"laser": (255, 0, 0), "box": (120, 100, 60), "robot": (120, 130, 140)}


@pytest.fixture
def screen(tmp_path: Path) -> Iterator[Dict[str, str]]:
    """Start a screen and a master, and return the environment to use them with."""
    command = ["Xvfb", "-displayfd", "1", "-screen", "0", "1000x700x24", "-fbdir", str(tmp_path)]
    xvfb = subprocess.Popen(command, stdout=subprocess.PIPE, universal_newlines=True)
    master = Master()
    try:
        assert xvfb.stdout is not None
        yield {
            **os.environ,
            "DISPLAY": ":" + xvfb.stdout.readline().strip(),
            "HOME": str(tmp_path),
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "ROS_LOG_DIR": str(tmp_path / "log"),
            "ROS_MASTER_URI": master.uri,
        }
    finally:
        master.kill()
        xvfb.terminate()
        xvfb.wait()


def pixels(file: Path) -> numpy.ndarray:
    """Return the colours on the screen: rows of red, green and blue.

    :param file: the screen's memory, an image in the format of xwd(1)
    """
    raw = file.read_bytes()
    header = struct.unpack(">25I", raw[:100])
    start, height, line, colours = header[0], header[5], header[12], header[19]
    data = numpy.frombuffer(raw, numpy.uint8, height * line, start + 12 * colours)
    return data.reshape(height, line // 4, 4)[:, :, 2::-1]


def test_rviz_shows_the_robot_in_its_world(screen: Dict[str, str], tmp_path: Path) -> None:
    command = ["roslaunch", "diff_drive_sim", "diff_drive.launch"]
    arguments = ["rviz:=true", "world:=arena", "scan_rate:=10", "theta:=0.5"]
    launch = subprocess.Popen(
        command + arguments, env=screen, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )

    def seen() -> Dict[str, int]:
        picture = pixels(tmp_path / "Xvfb_screen0").astype(int)
        return {
            name: int((abs(picture - colour).max(axis=2) <= 8).sum())
            for name, colour in COLOURS.items()
        }

    try:
        wait_until(
            lambda: all(count > 150 for count in seen().values()),
            lambda: f"pixels of each colour: {seen()}",
            60.0,
        )
    finally:
        launch.send_signal(signal.SIGINT)
        output = launch.communicate(timeout=30.0)[0].decode()
    assert "[ERROR]" not in output
