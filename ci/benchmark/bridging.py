"""Messages from one ROS to the other through the bridge, and within each ROS to compare with."""

import contextlib
import itertools
import json
import pathlib
import subprocess
import sys
import time
from typing import Any, Dict, Iterator, List, Tuple

from .analysis import percentile
from .context import Bench, Figures
from .cost import cpu_share, resident_memory
from .observers import wait_until
from .peer_programs import DOMAIN, SCRIPTS, WORKSPACE, rclpy_environment
from .peer_programs import RCLPY as PYTHON_OF_ROS2
from .processes import Session
from .stacks import RCLPY, RCLPY_EVENTS

ROSPY, TO_ROS2, TO_ROS1 = "rospy", "to_ros2", "to_ros1"
#: Bare rospy and rclpy in one process, from ROS 1 to ROS 2: the least that a bridge can take.
BARE = "bare"
#: Which ROS sends and which hears.
ENDS: Dict[str, Tuple[str, str]] = {
    ROSPY: ("1", "1"),
    RCLPY: ("2", "2"),
    RCLPY_EVENTS: ("2", "2"),
    TO_ROS2: ("1", "2"),
    TO_ROS1: ("2", "1"),
    BARE: ("1", "2"),
}
BRIDGE = WORKSPACE / "devel" / "lib" / "ros2_bridge" / "bridge"
#: What is between the ends.
PROGRAMS = {TO_ROS2: BRIDGE, TO_ROS1: BRIDGE, BARE: SCRIPTS / "bridge" / "bare.py"}
#: longest wait for the first message, and for the last, s
LIMIT = 40.0

_numbers = itertools.count(1)


def at_1_khz(bench: Bench, subject: str) -> Figures:
    """Measure single messages at 1 kHz."""
    return _hop(bench, subject, 1000.0, bench.seconds(4.0, 2.0), 1)


def load(bench: Bench, subject: str) -> Figures:
    """Measure what is lost at 4000 messages a second, and what fifty topics cost."""
    quick = _hop(bench, subject, 4000.0, bench.seconds(4.0, 2.0), 1)
    fifty = _hop(bench, subject, 20.0, bench.seconds(4.0, 2.0), 50)
    figures = {"lost": quick["lost"], "fifty_lost": fifty["lost"], "dropped": quick["dropped"]}
    if subject in PROGRAMS:  # the others show what whoever hears loses by itself
        figures.update(quick_cpu=quick["cpu_percent"], fifty_cpu=fifty["cpu_percent"])
    return figures


def many(bench: Bench, subject: str) -> Figures:
    """Measure what is lost of a hundred topics at 50 Hz, and what they cost."""
    heard = _hop(bench, subject, 50.0, bench.seconds(4.0, 2.0), 100)
    names = ("lost", "p50_us", "p99_us", "cpu_percent")
    return {name: heard[name] for name in names if name in heard}


def rest(bench: Bench, subject: str) -> Figures:
    """Measure the time from the bridge's start to its first message, then how it rests."""
    file = bench.session.directory / f"hop-{next(_numbers)}"
    with ends(bench.session, subject, file, 50.0, LIMIT / 4.0, 1):
        time.sleep(2.0)
        began = time.monotonic()
        with bridge(bench.session):
            wait_until(file.with_suffix(".any").exists, LIMIT, "message through the bridge")
            first = time.monotonic() - began
    with bridge(bench.session) as pid:
        time.sleep(8.0)  # a node's parameters come 5 s after it, if it does not describe them
        return {"first_s": first, "cpu_percent": cpu_share([pid], bench.seconds(6.0, 3.0))}


@contextlib.contextmanager
def bridge(session: Session, program: pathlib.Path = BRIDGE) -> Iterator[int]:
    """Run the bridge, or another; tell its process id."""
    environment = dict(session.environment, ROS_DOMAIN_ID=DOMAIN)
    process = session.start([sys.executable, str(program)], environment)
    try:
        yield process.pid
    finally:
        session.stop(process)


@contextlib.contextmanager
def ends(
    session: Session, subject: str, file: pathlib.Path, rate: float, seconds: float, topics: int
) -> Iterator[None]:
    """Run whoever hears and whoever sends: see hop.py."""
    sender, hearer = ENDS[subject]
    running: List["subprocess.Popen[bytes]"] = []
    numbers = [f"{rate:g}", f"{seconds:g}", str(topics)]
    try:
        for what, ros in (("hear", hearer), ("send", sender)):
            python = str(PYTHON_OF_ROS2) if ros == "2" else sys.executable
            script = str(SCRIPTS / "bridge" / "hop.py")
            environment = session.environment
            if ros == "2":
                environment = rclpy_environment(events=subject == RCLPY_EVENTS)
                environment["PYTHONPATH"] = str(SCRIPTS / "ros2")
            command = [python, script, what, ros, *numbers, str(file)]
            running.append(session.start(command, environment))
        yield
    finally:
        session.stop(*reversed(running))


def _hop(bench: Bench, subject: str, rate: float, seconds: float, topics: int) -> Figures:
    file = bench.session.directory / f"hop-{next(_numbers)}"
    figures: Figures = {}
    with contextlib.ExitStack() as stack:
        pids: List[int] = []
        if subject in PROGRAMS:
            pids.append(stack.enter_context(bridge(bench.session, PROGRAMS[subject])))
        stack.enter_context(ends(bench.session, subject, file, rate, seconds, topics))
        wait_until(file.with_suffix(".first").exists, LIMIT, "the first message")
        if pids:
            time.sleep(0.5)
            figures["cpu_percent"] = cpu_share(pids, seconds - 1.0)
            figures["resident_mb"] = resident_memory(pids)
        wait_until(file.exists, LIMIT, "the last message")
    heard: Any = json.loads(file.read_text("utf-8"))
    figures["p50_us"] = percentile(heard["took"], 0.5)
    figures["p99_us"] = percentile(heard["took"], 0.99)
    figures["lost"], figures["dropped"] = heard["lost"], heard["dropped"]
    return figures
