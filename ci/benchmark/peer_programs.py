"""Peers of the workspace's nodes: locations and builds.

Compiled programs are kept in build/benchmark for the next time.
"""

import os
import pathlib
import subprocess
import sys
from typing import Dict, List

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = WORKSPACE / "ci" / "benchmark" / "peers"
ROSCPP = WORKSPACE / "build" / "benchmark" / "roscpp"
#: Python of the environment that ./ci/ros2 makes.
RCLPY = WORKSPACE / "build" / "ros2" / "bin" / "python"
#: The subjects that need rclpy.
NEED_RCLPY = ("rclpy", "to_ros2", "to_ros1")
#: ROS 2 domain: two runs in one domain would see each other's nodes, with the same names.
DOMAIN = os.environ.get("ROS_DOMAIN_ID", "97")


def executable(package: str, name: str, *arguments: str) -> List[str]:
    """Return the command of one of the workspace's executables."""
    return [str(WORKSPACE / "devel" / "lib" / package / name), *arguments]


def peer(script: str, *arguments: str) -> List[str]:
    """Return the command of one of the scripts in peers."""
    return [sys.executable, str(SCRIPTS / script), *arguments]


def rclpy_peer(script: str, *arguments: str) -> List[str]:
    """Return the command of one of the scripts in peers/ros2; see :func:`rclpy_environment`."""
    return [str(RCLPY), str(SCRIPTS / "ros2" / script), *arguments]


def prepare(fetch: bool) -> Dict[str, str]:
    """Build the peers.

    :param fetch: whether to fetch rclpy from PyPI if it is missing
    :returns: the reason for each omitted peer, by its name
    :raises subprocess.CalledProcessError: if the roscpp programs cannot be built; the output has
        been shown
    """
    ROSCPP.mkdir(parents=True, exist_ok=True)
    include = f"-DWORKSPACE_INCLUDE={WORKSPACE / 'devel' / 'include'}"
    python = "-DPYTHON_EXECUTABLE=/usr/bin/python3"
    for command in (
        ["cmake", "-S", str(SCRIPTS / "roscpp"), "-B", str(ROSCPP), include, python],
        ["cmake", "--build", str(ROSCPP), "--parallel", "2"],
    ):
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if done.returncode != 0:
            print(done.stdout.decode(errors="replace"))
            done.check_returncode()
    reason = make_rclpy() if fetch else "" if RCLPY.exists() else "not fetched yet"
    return dict.fromkeys(NEED_RCLPY, reason) if reason else {}


def make_rclpy() -> str:
    """Make the environment of ./ci/ros2 if it is missing.

    :returns: the reason if that is not possible, else nothing
    """
    command = [str(WORKSPACE / "ci" / "ros2")]
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    lines = result.stdout.decode(errors="replace").splitlines() or ["ci/ros2 failed"]
    return lines[-1] if result.returncode else ""


def rclpy_environment() -> Dict[str, str]:
    """Return an environment without ROS 1, whose std_msgs would hide that of ROS 2."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("ROS", "CMAKE", "CATKIN")) and name != "PYTHONPATH"
    }
    # Only for nodes of this machine, separate from other systems.
    return dict(
        environment,
        ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST",
        ROS_DOMAIN_ID=DOMAIN,
        PYTHONPATH=str(WORKSPACE),
    )
