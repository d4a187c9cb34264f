"""What README says to copy into a workspace of one's own is all that it takes."""

import os
import shutil
import signal
import subprocess
import time
from typing import Dict

import pytest
from conftest import SOURCES

COPIED = ("nodekit", "nodekit_msgs", "lifecycle_msgs", "basic_comms")


@pytest.fixture(scope="module")
def environment(
    tmp_path_factory: "pytest.TempPathFactory", underlay: Dict[str, str]
) -> Dict[str, str]:
    """The environment of a workspace with copies of these packages and nothing else."""
    workspace = tmp_path_factory.mktemp("own")
    for package in COPIED:
        shutil.copytree(str(SOURCES / package), str(workspace / "src" / package))
    # Without the tests' targets and what other languages would generate, which takes longest.
    subprocess.check_call(
        [
            *("catkin_make", "--directory", str(workspace)),
            "-DPYTHON_EXECUTABLE=/usr/bin/python3",
            "-DCATKIN_ENABLE_TESTING=OFF",
        ],
        env={**underlay, "ROS_LANG_DISABLE": "gencpp:geneus:genlisp:gennodejs"},
    )
    setup = 'source "$0/devel/setup.bash"; env -0'
    listed = subprocess.check_output(["bash", "-c", setup, str(workspace)], env=underlay)
    return dict(line.split("=", 1) for line in os.fsdecode(listed).split("\0") if line)


def test_the_course_runs(environment: Dict[str, str]) -> None:
    launch = subprocess.Popen(["roslaunch", "basic_comms", "cw1.launch"], env=environment)
    try:
        give_up = time.monotonic() + 60.0
        while subprocess.call(["rosnode", "list"], env=environment, timeout=60) != 0:
            assert launch.poll() is None and time.monotonic() < give_up
        heard = subprocess.check_output(
            ["rostopic", "echo", "-n", "1", "/proc_signal"], env=environment, timeout=60
        )
        assert heard.startswith(b"data: ")
        described = subprocess.check_output(
            ["rosrun", "nodekit", "describe", "/process"], env=environment, timeout=60
        )
        assert b"amplitude_scale" in described
    finally:
        launch.send_signal(signal.SIGINT)
        launch.wait(timeout=60)


def test_no_other_package_is_there(environment: Dict[str, str]) -> None:
    for package in ("topic_scope", "motor_control"):
        found = subprocess.run(
            ["rospack", "find", package], env=environment, stderr=subprocess.DEVNULL
        )
        assert found.returncode != 0
