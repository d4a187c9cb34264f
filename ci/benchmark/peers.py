"""What the workspace is compared with: where it is, and how it is built.

All of it goes to build/benchmark, and is kept there for the next time.
"""

import os
import pathlib
import shutil
import subprocess
from typing import Dict, List, NamedTuple, Optional

HERE = pathlib.Path(__file__).resolve().parent
SCRIPTS = HERE / "peers"
WORKSPACE = HERE.parents[1]
BUILD = WORKSPACE / "build" / "benchmark"

RCLPY = ["ros-rclpy", "ros-std-msgs", "ros-rmw-fastrtps-cpp"]
#: for which versions of Python these have wheels
RCLPY_PYTHONS = ["3.11", "3.12", "3.13"]
#: longest time for each of the steps that fetch from PyPI, s
FETCH_LIMIT = 180.0


class Peers(NamedTuple):
    """The programs of the peers."""

    #: directory of the roscpp programs
    roscpp: pathlib.Path
    #: relay of topic_tools
    relay: Optional[pathlib.Path]
    #: Python that has rclpy
    rclpy: Optional[pathlib.Path]
    #: why a peer is left out, by its name
    left_out: Dict[str, str]


def prepare(fetch: bool) -> Peers:
    """Build the peers as far as they are not there yet.

    :param fetch: fetch rclpy from PyPI where it is not there
    """
    left_out: Dict[str, str] = {}
    build_roscpp()
    relay = find_relay()
    if relay is None:
        left_out["relay"] = "topic_tools is not installed"
    rclpy = BUILD / "rclpy" / "bin" / "python"
    reason = "" if has_rclpy(rclpy) else build_rclpy(rclpy) if fetch else "not fetched yet"
    if reason:
        left_out["rclpy"] = reason
    return Peers(BUILD / "roscpp", relay, None if reason else rclpy, left_out)


def build_roscpp() -> None:
    """Build the roscpp programs.

    :raises subprocess.CalledProcessError: if that fails; the output has been shown
    """
    target = BUILD / "roscpp"
    target.mkdir(parents=True, exist_ok=True)
    include = WORKSPACE / "devel" / "include"
    configure = ["cmake", "-S", str(SCRIPTS / "roscpp"), "-B", str(target)]
    run(configure + [f"-DWORKSPACE_INCLUDE={include}", "-DPYTHON_EXECUTABLE=/usr/bin/python3"])
    run(["cmake", "--build", str(target), "--parallel", "2"])


def run(command: List[str]) -> None:
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if result.returncode != 0:
        print(result.stdout.decode(errors="replace"))
        result.check_returncode()


def find_relay() -> Optional[pathlib.Path]:
    """Find the relay of topic_tools, in the distribution's ROS or in /opt/ros/noetic."""
    for prefix in ("/opt/ros/noetic", "/usr"):
        program = pathlib.Path(prefix, "lib", "topic_tools", "relay")
        if program.exists():
            return program
    return None


def has_rclpy(python: pathlib.Path) -> bool:
    """Tell whether a Python can import rclpy."""
    if not python.exists():
        return False
    command = [str(python), "-c", "import rclpy, std_msgs.msg"]
    return subprocess.run(command, env=rclpy_environment(), capture_output=True).returncode == 0


def build_rclpy(python: pathlib.Path) -> str:
    """Install rclpy in a virtual environment of its own.

    :returns: why it is not possible; empty if it is done
    """
    creator = find_program(suitable_pythons())
    if creator is None:
        return f"its wheels need Python {' or '.join(RCLPY_PYTHONS)}"
    target = python.parents[1]
    shutil.rmtree(target, ignore_errors=True)
    steps: List[List[str]] = [
        [creator, "-m", "venv", str(target)],
        [str(python), "-m", "pip", "install", "--quiet", *RCLPY],
    ]
    for command in steps:
        try:
            subprocess.run(
                command,
                check=True,
                env=rclpy_environment(),
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                timeout=FETCH_LIMIT,
            )
        except subprocess.TimeoutExpired:
            return "PyPI did not answer in time"
        except subprocess.CalledProcessError as error:
            lines = error.stdout.decode(errors="replace").splitlines()
            return lines[-1] if lines else f"{command[0]} failed"
    return "" if has_rclpy(python) else "what PyPI has cannot be imported"


def suitable_pythons() -> List[str]:
    """Return the names of the Pythons that rclpy's wheels are for, the system's first."""
    command = ["/usr/bin/python3", "-c", "import sys; print('%d.%d' % sys.version_info[:2])"]
    version = subprocess.run(command, capture_output=True, check=True).stdout.decode().strip()
    names = [f"python{number}" for number in RCLPY_PYTHONS]
    return ["/usr/bin/python3"] * (version in RCLPY_PYTHONS) + names


def find_program(names: List[str]) -> Optional[str]:
    """Return the path of the first of these programs that there is."""
    for name in names:
        path = shutil.which(name)
        if path is not None:
            return path
    return None


def rclpy_environment() -> Dict[str, str]:
    """Return an environment without ROS 1, whose std_msgs would hide that of ROS 2."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("ROS", "CMAKE", "CATKIN")) and name != "PYTHONPATH"
    }
    # Only for nodes of this machine, and away from those of other people's systems.
    environment.update(ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST", ROS_DOMAIN_ID="97")
    return environment
