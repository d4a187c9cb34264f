"""The stacks that are compared: a generator, a process and an observer of each make."""

import contextlib
import itertools
import pathlib
import subprocess
import sys
import time
from typing import Callable, Iterator, List, NamedTuple

from . import record
from .analysis import Sample
from .cost import cpu_share
from .observers import Recorder, wait_until
from .pausing import DRAIN_S
from .peer_programs import SCRIPTS, WORKSPACE, Peers, rclpy_environment
from .processes import Session

OURS, ROSPY, ROSCPP, RELAY = "basic_comms", "rospy", "roscpp", "relay"
RCLPY, COURSE = "rclpy", "course"
#: rclpy with its experimental EventsExecutor in place of its ``spin``.
RCLPY_EVENTS = "rclpy_events"
#: The workspace's own, with a process node that is managed, and active.
MANAGED = "managed"
#: Both nodes in one process: the workspace's by host, roscpp's by pointers, as nodelets do it.
HOST, INTRAPROCESS = "host", "roscpp_intraprocess"
#: Where among the peers the nodes of a stack in Python are.
_FOLDERS = {ROSPY: "stock", COURSE: "course"}

#: how long answers to the last samples of a run may take, s
PATIENCE_S = 2.0

EXECUTABLES = WORKSPACE / "devel" / "lib" / "basic_comms"

_numbers = itertools.count(1)


class Pair(NamedTuple):
    """A generator and a process that are up, and what is seen of them."""

    #: all that belongs to them, whoever hears before whoever sends
    pids: List[int]
    #: those whose processor time counts
    nodes: List[int]
    #: returns what was published so far, and what the observer has got
    sent: Callable[[], List[Sample]]
    received: Callable[[], List[Sample]]


class Run(NamedTuple):
    """What a stack did in a run, or has done by the end of a turn."""

    sent: List[Sample]
    received: List[Sample]
    #: of generator and process together, % of one core
    cpu: float
    #: from when to when that was measured, s
    since: float
    until: float


def watch(pair: Pair, settle: float, seconds: float) -> Run:
    """Watch a stack that is running.

    :param settle: how long it runs before, s
    :param seconds: how long it is measured, s
    """
    time.sleep(settle)
    since = time.monotonic()
    cpu = cpu_share(pair.nodes, seconds)
    until = time.monotonic()
    _wait_for_answers(pair, since, until)
    received = pair.received()  # first: of each answer, the sample is there as well
    return Run(pair.sent(), received, cpu, since, until)


def _wait_for_answers(pair: Pair, since: float, until: float) -> None:
    """Wait until as many answers are there as samples were sent; not for long: some may be lost."""
    due = sum(since <= sample.moment <= until for sample in pair.sent())
    give_up = time.monotonic() + PATIENCE_S
    while time.monotonic() < give_up:
        time.sleep(DRAIN_S)
        if sum(answer.moment >= since for answer in pair.received()) >= due:
            return


def ours(executable: str, *arguments: str) -> List[str]:
    """Return the command of one of the workspace's own nodes."""
    return [str(EXECUTABLES / executable), *arguments]


def peer(script: str, *arguments: str) -> List[str]:
    """Return the command of one of the scripts in peers."""
    return [sys.executable, str(SCRIPTS / script), *arguments]


def process_command(peers: Peers, stack: str) -> List[str]:
    """Return the command of a stack's process node, where it has a process of its own."""
    if stack == OURS:
        return ours("process.py")
    if stack == MANAGED:
        return ours("process.py", "_managed:=true")
    if stack == ROSCPP:
        return [str(peers.roscpp / "process")]
    if stack == RELAY:
        return [str(peers.relay), "signal", "proc_signal", "__name:=process"]
    return peer(_FOLDERS[stack] + "/process.py")


def generator_command(peers: Peers, stack: str, file: pathlib.Path, rate: float) -> List[str]:
    """Return the command of a stack's generator, which records when it publishes.

    Where both nodes are in one process, it is that of both.

    The relay has the workspace's own, since topic_tools brings none.
    """
    if stack == ROSCPP:
        return [str(peers.roscpp / "generator"), str(file), f"_rate:={rate:g}"]
    if stack == INTRAPROCESS:
        return [str(peers.roscpp / "together"), str(file), f"_rate:={rate:g}"]
    if stack == HOST:
        return peer("recorded_host.py", str(file))
    if stack in _FOLDERS:
        return peer(_FOLDERS[stack] + "/signal_generator.py", str(file), f"_rate:={rate:g}")
    return peer("recorded_generator.py", str(file), f"_rate:={rate:g}")


def output_type(stack: str) -> str:
    """Return the type of a stack's proc_signal."""
    return "basic_comms/signal_msg" if stack == RELAY else "std_msgs/Float32"


@contextlib.contextmanager
def up(session: Session, peers: Peers, stack: str, rate: float) -> Iterator[Pair]:
    """Have a stack up and running, from its first answer on.

    :param rate: of the generator, Hz
    """
    file = session.directory / f"record-{next(_numbers)}"
    if stack in (RCLPY, RCLPY_EVENTS):
        with _up_rclpy(session, peers, stack, rate, file) as pair:
            yield pair
        return
    group = f"/run{next(_numbers)}"
    commands = [generator_command(peers, stack, file, rate)]
    if stack not in (HOST, INTRAPROCESS):
        commands.insert(0, process_command(peers, stack))
    with session.node() as node:
        if stack == HOST:  # its process takes no parameters for its members
            node.master("setParam", group + "/signal_generator/rate", rate)
        recorder = Recorder(node, group + "/proc_signal", output_type(stack))
        with session.running(*commands, environment=session.in_group(group)) as pids:
            if stack == MANAGED:
                _activate(session, group + "/process")
            recorder.wait()
            yield Pair(pids, pids, lambda: record.read(file), recorder.samples)


def _activate(session: Session, node: str) -> None:
    session.wait_for(node)
    for transition in ("configure", "activate"):
        command = ["rosrun", "nodekit", "lifecycle", "set", node, transition]
        subprocess.run(command, env=session.environment, check=True, stdout=subprocess.DEVNULL)


@contextlib.contextmanager
def _up_rclpy(
    session: Session, peers: Peers, stack: str, rate: float, file: pathlib.Path
) -> Iterator[Pair]:
    python = str(peers.rclpy)
    environment = dict(rclpy_environment(events=stack == RCLPY_EVENTS), PYTHONPATH=str(WORKSPACE))
    seen = file.with_suffix(".seen")
    commands = [
        [python, str(SCRIPTS / "ros2" / "observer.py"), str(seen)],
        [python, str(SCRIPTS / "ros2" / "process.py")],
        [python, str(SCRIPTS / "ros2" / "generator.py"), str(file), f"{rate:g}"],
    ]
    with session.running(*commands, environment=environment) as pids:
        wait_until(lambda: seen.exists() and bool(record.read(seen)), 30.0, "answer from rclpy")
        yield Pair(pids, pids[1:], lambda: record.read(file), lambda: record.read(seen))
