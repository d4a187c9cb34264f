"""What the workspace is compared with: where it is, and how it is built.

What is compiled goes to build/benchmark, and is kept there for the next time.
"""

import os
import pathlib
import subprocess
import sys
from typing import Dict, List, NamedTuple, Optional

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = WORKSPACE / "ci" / "benchmark" / "peers"
BUILD = WORKSPACE / "build" / "benchmark"

#: What is left out where there is no rclpy.
NEED_RCLPY = ("rclpy", "rclpy_events", "to_ros2", "to_ros1", "bare")
#: Least calls of a timer of 1 ms in a second of an executor that works.
_LEAST_CALLS = 100
#: Longest time for finding that out, s.
_PROBE_S = 20.0
#: The domain of ROS 2: in one, two runs at a time would see each other's nodes, of the same names.
DOMAIN = os.environ.get("ROS_DOMAIN_ID", "97")
#: Python of the environment that ./ci/ros2 makes
RCLPY = WORKSPACE / "build" / "ros2" / "bin" / "python"


def module(name: str, *arguments: str) -> List[str]:
    """Return the command that runs one of the modules of ``ci``.

    :param name: e.g. ``endurance.observe``
    """
    return [sys.executable, str(WORKSPACE / "ci"), name, *arguments]


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
    reason = make_rclpy() if fetch else "" if RCLPY.exists() else "not fetched yet"
    if reason:
        left_out.update(dict.fromkeys(NEED_RCLPY, reason))
    else:
        events = try_events_executor()
        if events:
            left_out["rclpy_events"] = events
    return Peers(BUILD / "roscpp", relay, None if reason else RCLPY, left_out)


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
    """Find the relay of topic_tools, in a ROS of its own or in the distribution's."""
    for prefix in [*os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep), "/usr"]:
        program = pathlib.Path(prefix, "lib", "topic_tools", "relay")
        if program.exists():
            return program
    return None


def make_rclpy() -> str:
    """Have ./ci/ros2 make its environment, if it is not there.

    :returns: why it is not possible; empty if it is done
    """
    command = [str(WORKSPACE / "ci" / "ros2")]
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    lines = result.stdout.decode(errors="replace").splitlines() or ["ci/ros2 failed"]
    return lines[-1] if result.returncode else ""


def try_events_executor() -> str:
    """Have rclpy's EventsExecutor call a timer: with some wheels it is there, and does nothing.

    :returns: why it is left out; empty if it works
    """
    command = [str(RCLPY), str(SCRIPTS / "ros2" / "events_probe.py")]
    try:
        done = subprocess.run(
            command,
            env=rclpy_environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=_PROBE_S,
        )
    except subprocess.TimeoutExpired:
        return "this rclpy's EventsExecutor hangs"
    calls = int(done.stdout or -1)
    if calls < 0:
        return "this rclpy has no EventsExecutor"
    if calls < _LEAST_CALLS:
        return f"this rclpy's EventsExecutor calls a timer of 1 ms {calls} times in a second"
    return ""


def rclpy_environment(events: bool = False) -> Dict[str, str]:
    """Return an environment without ROS 1, whose std_msgs would hide that of ROS 2.

    :param events: whether nodes are spun by rclpy's EventsExecutor, as far as they are prepared
    """
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("ROS", "CMAKE", "CATKIN")) and name != "PYTHONPATH"
    }
    # Only for nodes of this machine, and away from those of other people's systems.
    environment.update(ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST", ROS_DOMAIN_ID=DOMAIN)
    environment["BENCH_EXECUTOR"] = "events" if events else "single"
    return environment
