"""Large messages at 30 Hz from a camera to its subscribers: latency, processor time, losses."""

import functools
import itertools
import pathlib
import time
from typing import Dict, List, NamedTuple

import numpy as np

from . import record
from .context import Bench, Figures
from .cost import cpu_share
from .peer_programs import ROSCPP as ROSCPP_PROGRAMS
from .peer_programs import peer, rclpy_environment, rclpy_peer
from .recorder import wait_until
from .stacks import RCLPY, ROSCPP, ROSPY

NODEKIT, VIEWS = "nodekit", "views"
#: Camera and subscribers in one process; of roscpp, as its nodelets are.
NODEKIT_INSIDE, ROSCPP_INSIDE = "nodekit in one process", "roscpp in one process"
STACKS = [NODEKIT, VIEWS, NODEKIT_INSIDE, ROSPY, ROSCPP, ROSCPP_INSIDE, RCLPY]
#: Messages, by the name of their size: kind, and length of their data [bytes].
MESSAGES = {
    "0.3 MB": ("image", 307_200),
    "1 MB": ("image", 921_600),
    "6.2 MB": ("image", 6_220_800),
    "300 000 points": ("points", 4_800_000),
}
#: Numbers of subscribers.
COUNTS = (1, 3)
#: Time for caches, and length of a turn [s].
SETTLE_S, TURN_S = 1.0, 3.0
#: Time for the last messages to arrive [s].
DRAIN_S = 0.3

_numbers = itertools.count(1)


class Case(NamedTuple):
    """Subject of the row."""

    stack: str
    size: str
    subscribers: int

    @property
    def name(self) -> str:
        """The subject's name in the results."""
        return f"{self.stack}, {self.size} to {self.subscribers}"


CASES: Dict[str, Case] = {
    case.name: case
    for case in (Case(*parts) for parts in itertools.product(STACKS, MESSAGES, COUNTS))
    if case.stack != RCLPY or MESSAGES[case.size][0] == "image"
}


def measure(bench: Bench, subject: str) -> Figures:
    """Run a camera and its subscribers for some seconds."""
    case, number = CASES[subject], next(_numbers)
    files = [bench.session.directory / f"images-{number}-{n}" for n in range(case.subscribers + 1)]
    environment = bench.session.environment if case.stack != RCLPY else rclpy_environment()
    environment = dict(environment, ROS_NAMESPACE=f"/images{number}")
    with bench.session.up(*commands(case, files), environment=environment) as pids:
        for file in files:
            wait_until(functools.partial(record.read, file), 30.0, f"message of {subject}")
        time.sleep(SETTLE_S)
        since = time.monotonic()
        cpu = cpu_share(pids, bench.seconds(TURN_S, 1.0))
        until = time.monotonic()
        time.sleep(DRAIN_S)
        *received, sent = map(record.read, files)
    return figures(sent, received, since, until, cpu)


def commands(case: Case, files: List[pathlib.Path]) -> List[List[str]]:
    """Return the commands of a camera and its subscribers.

    :param files: records of the subscribers, and of the camera
    """
    names = [str(file) for file in files]
    if case.stack in (NODEKIT_INSIDE, ROSCPP_INSIDE):
        return [command(case, "both", *names)]
    of_subscribers = [command(case, "subscribe", name) for name in names[:-1]]
    return [*of_subscribers, command(case, "publish", names[-1])]


def command(case: Case, role: str, *files: str) -> List[str]:
    """Return the command of one process."""
    kind, size = MESSAGES[case.size]
    arguments = (str(size), str(case.subscribers), *files)
    if case.stack == RCLPY:
        return rclpy_peer("images.py", role, *arguments)
    if case.stack in (ROSCPP, ROSCPP_INSIDE):
        return [str(ROSCPP_PROGRAMS / "images"), role, kind, *arguments]
    stack = NODEKIT if case.stack == NODEKIT_INSIDE else case.stack
    return peer("images.py", role, stack, kind, *arguments)


def figures(
    sent: List[record.Sample],
    received: List[List[record.Sample]],
    since: float,
    until: float,
    cpu: float,
) -> Figures:
    """Return the figures of the messages that were sent during a time.

    :param sent: numbers of the messages, and when they were sent
    :param received: the same of each subscriber
    :param since: start of the time on the monotonic clock [s]
    :param until: its end [s]
    :param cpu: processor time of all processes [% of a core]
    :raises ValueError: if nothing was received
    """
    due = {one.value: one.moment for one in sent if since <= one.moment <= until}
    arrived = [{one.value: one.moment for one in samples} for samples in received]
    took = [
        1e3 * (one[number] - moment)
        for one in arrived
        for number, moment in due.items()
        if number in one
    ]
    if not took:
        raise ValueError("no message was received")
    p50, p99 = map(float, np.percentile(took, [50.0, 99.0]))
    lost = len(due) * len(arrived) - len(took)
    return {"p50_ms": p50, "p99_ms": p99, "cpu_percent": cpu, "lost": lost}
