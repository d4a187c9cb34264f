"""Messages and goals through the bridge to ROS 2, and within each ROS for comparison."""

import contextlib
import itertools
import json
import pathlib
import time
from typing import Any, Dict, Iterator, List, Tuple

import numpy as np

from . import images, record
from .action_client import ActionClient, start
from .context import Bench, Figures
from .cost import cpu_share, usage
from .peer_programs import DOMAIN, executable, peer, rclpy_environment, rclpy_peer
from .peer_programs import RCLPY as PYTHON_OF_ROS2
from .processes import Session
from .recorder import wait_until
from .stacks import RCLPY, ROSPY

TO_ROS2, TO_ROS1 = "to_ros2", "to_ros1"
#: The sender's ROS and the receiver's.
ENDS: Dict[str, Tuple[str, str]] = {
    ROSPY: ("1", "1"),
    RCLPY: ("2", "2"),
    TO_ROS2: ("1", "2"),
    TO_ROS1: ("2", "1"),
}
#: Longest wait for the first message, and for the last [s].
LIMIT = 40.0
#: Duration of a goal, with feedback 20 times a second, and longest wait for its end [s].
GOAL_S, ENDED_WITHIN = 0.2, 20.0
#: Size of a large message [bytes].
IMAGE_BYTES = images.MESSAGES["6.2 MB"][1]
#: Goals before the measurement, while connections settle.
FIRST_GOALS = 3

_numbers = itertools.count(1)


def measure_hop(bench: Bench, subject: str) -> Figures:
    """Measure messages at 1 kHz."""
    return _measure(bench, subject, 1000.0, 1)


def measure_load(bench: Bench, subject: str) -> Figures:
    """Measure 4000 messages a second, then a hundred topics at 50 Hz."""
    fast, many = _measure(bench, subject, 4000.0, 1), _measure(bench, subject, 50.0, 100)
    figures = {f"fast_{name}": value for name, value in fast.items()}
    figures.update((f"many_{name}", value) for name, value in many.items())
    return figures


def measure_images(bench: Bench, subject: str) -> Figures:
    """Measure messages of 6.2 MB at 30 Hz."""
    with contextlib.ExitStack() as stack:
        pids: List[int] = []
        if subject in (TO_ROS2, TO_ROS1):
            pids.append(stack.enter_context(run_bridge(bench.session)))
        sent, received = stack.enter_context(run_cameras(bench.session, subject))
        time.sleep(images.SETTLE_S)
        since, seconds = time.monotonic(), bench.seconds(6.0, 3.0)
        if pids:
            cpu = cpu_share(pids, seconds)
        else:
            time.sleep(seconds)
            cpu = 0.0
        until = time.monotonic()
        time.sleep(images.DRAIN_S)
    samples = record.read(sent)
    figures = images.figures(samples, [record.read(received)], since, until, cpu)
    due = sum(since <= one.moment <= until for one in samples)
    return {
        "p50_ms": figures["p50_ms"],
        "lost_percent": 100.0 * figures["lost"] / due,
        **({"cpu_percent": cpu} if pids else {}),
    }


def measure_actions(bench: Bench, subject: str) -> Figures:
    """Measure goals one after the other: time to acceptance, and age of the feedback."""
    client_ros, server_ros = ENDS[subject]
    name, goals = f"/measured{next(_numbers)}", int(bench.seconds(40.0, 10.0))
    with contextlib.ExitStack() as stack:
        server = start(bench.session, "server", server_ros, name)
        stack.callback(bench.session.stop, server)
        if subject in (TO_ROS2, TO_ROS1):
            stack.enter_context(run_bridge(bench.session))
        client = ActionClient(bench.session, client_ros, name)
        stack.callback(client.close)
        client.wait_for_server()
        for number in range(FIRST_GOALS + goals):
            if number == FIRST_GOALS:
                client.feedback.clear()
                client.accepted.clear()
            key = f"goal{number}"
            client.send(key, GOAL_S)
            wait_until(lambda: client.ends[key], ENDED_WITHIN, f"end of {key}")
            if client.ends[key] != [["SUCCEEDED", key]]:
                raise ValueError(f"{key} ended as {client.ends[key]}")
    return {
        "accept_p50_us": float(np.median(list(client.accepted.values()))),
        "feedback_p50_us": float(np.median(client.feedback)),
    }


def bridge_command(session: Session) -> Tuple[List[str], Dict[str, str]]:
    """Return the bridge's command and environment."""
    return executable("ros2_bridge", "bridge"), {**session.environment, "ROS_DOMAIN_ID": DOMAIN}


@contextlib.contextmanager
def run_bridge(session: Session) -> Iterator[int]:
    """Run the bridge for the duration of the context; its process id is returned."""
    command, environment = bridge_command(session)
    with session.up(command, environment=environment) as (pid,):
        yield pid


@contextlib.contextmanager
def run_ends(
    session: Session, subject: str, file: pathlib.Path, rate: float, seconds: float, topics: int
) -> Iterator[None]:
    """Run receiver and sender for the duration of the context: see peers/bridge/hop.py."""
    sender, receiver = ENDS[subject]
    processes = []
    try:
        for role, ros in (("receive", receiver), ("send", sender)):
            command = peer("bridge/hop.py", role, ros, f"{rate:g}", f"{seconds:g}", str(topics))
            environment = session.environment
            if ros == "2":
                command[0], environment = str(PYTHON_OF_ROS2), rclpy_environment()
            processes.append(session.start([*command, str(file)], environment))
        yield
    finally:
        session.stop(*reversed(processes))


@contextlib.contextmanager
def run_cameras(session: Session, subject: str) -> Iterator[Tuple[pathlib.Path, pathlib.Path]]:
    """Run a camera and its subscriber for the duration of the context: see peers/images.py.

    :returns: the records of sent and received messages, after the first has arrived
    """
    number = next(_numbers)
    sent, received = (session.directory / f"{end}-{number}" for end in ("sent", "received"))
    sender, receiver = ENDS[subject]
    with contextlib.ExitStack() as stack:
        for role, ros, file in (("subscribe", receiver, received), ("publish", sender, sent)):
            environment = session.environment if ros == "1" else rclpy_environment()
            environment = dict(environment, ROS_NAMESPACE=f"/images{number}")
            arguments = [str(IMAGE_BYTES), "1", str(file)]
            command = rclpy_peer("images.py", role, *arguments)
            if ros == "1":
                command = peer("images.py", role, "rospy", "bytes", *arguments)
            stack.enter_context(session.up(command, environment=environment))
        wait_until(lambda: record.read(received), LIMIT, "the first message")
        yield sent, received


def _measure(bench: Bench, subject: str, rate: float, topics: int) -> Figures:
    file = bench.session.directory / f"hop-{next(_numbers)}"
    seconds = bench.seconds(3.0, 2.0)
    figures: Figures = {}
    with contextlib.ExitStack() as stack:
        pids: List[int] = []
        if subject in (TO_ROS2, TO_ROS1):
            pids.append(stack.enter_context(run_bridge(bench.session)))
        stack.enter_context(run_ends(bench.session, subject, file, rate, seconds, topics))
        wait_until(file.with_suffix(".first").exists, LIMIT, "the first message")
        if pids:
            time.sleep(0.5)
            figures["cpu_percent"] = cpu_share(pids, seconds - 1.0)
            figures["resident_mb"] = usage(pids[0]).memory / 1024.0
        wait_until(file.exists, LIMIT, "the last message")
    received: Any = json.loads(file.read_text("utf-8"))
    figures["p50_us"] = float(np.median(received["took"]))
    figures["lost"] = received["lost"]
    return figures
