"""The compared stacks: generator, process node and observer by each client library."""

import contextlib
import itertools
import pathlib
import time
from typing import Callable, Iterator, List, NamedTuple

from . import record
from .cost import cpu_share
from .peer_programs import ROSCPP as ROSCPP_PROGRAMS
from .peer_programs import executable, peer, rclpy_environment, rclpy_peer
from .processes import DRAIN_S, Session
from .record import Sample
from .recorder import wait_until

OURS, ROSPY, ROSCPP, RCLPY = "basic_comms", "rospy", "roscpp", "rclpy"
#: Two nodes in the style of the course.
COURSE = "course"

#: Longest wait for answers to the last samples of a run [s].
PATIENCE_S = 2.0

_numbers = itertools.count(1)


class Pair(NamedTuple):
    """A running generator and process node, and observations of them."""

    #: all processes, receivers before senders
    pids: List[int]
    #: processes that count for the processor time
    nodes: List[int]
    #: return the samples published so far, and those that the observer has received
    sent: Callable[[], List[Sample]]
    received: Callable[[], List[Sample]]


class Run(NamedTuple):
    """Samples and answers of a pair in a turn, and their cost [% of a core] in some time [s]."""

    sent: List[Sample]
    received: List[Sample]
    cpu: float
    since: float
    until: float


def watch(pair: Pair, settle: float, seconds: float) -> Run:
    """Observe a running pair.

    :param settle: time before the measurement [s]
    :param seconds: duration of the measurement [s]
    """
    time.sleep(settle)
    since = time.monotonic()
    cpu = cpu_share(pair.nodes, seconds)
    until = time.monotonic()
    _wait_for_answers(pair, since, until)
    received = pair.received()  # first: the sample of each answer is then recorded as well
    return Run(pair.sent(), received, cpu, since, until)


def _wait_for_answers(pair: Pair, since: float, until: float) -> None:
    """Wait for an answer to each sample; not for long, because answers may be lost."""
    due = sum(since <= sample.moment <= until for sample in pair.sent())
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        time.sleep(DRAIN_S)
        if sum(answer.moment >= since for answer in pair.received()) >= due:
            return


def _commands(stack: str, file: str, rate: str) -> List[List[str]]:
    """Return the commands of a stack of ROS 1, the process node's before the generator's.

    :param file: record of the generator's publications
    """
    if stack == ROSCPP:
        program = str(ROSCPP_PROGRAMS / "generator")
        return [[str(ROSCPP_PROGRAMS / "process")], [program, file, rate]]
    if stack == ROSPY:
        return [peer("stock/process.py"), peer("stock/signal_generator.py", file, rate)]
    generator = "basic_comms.nodes.signal_generator:SignalGenerator"
    return [
        executable("basic_comms", "process.py"),
        peer("recorded.py", file, "time_x", generator, rate),
    ]


@contextlib.contextmanager
def up(session: Session, stack: str, rate: float) -> Iterator[Pair]:
    """Run a stack; the context begins with its first answer.

    :param rate: of the generator [Hz]
    """
    number = next(_numbers)
    file = session.directory / f"record-{number}"
    if stack == RCLPY:
        with _up_rclpy(session, file, rate) as pair:
            yield pair
        return
    group = f"/run{number}"
    with session.record(group + "/proc_signal", "std_msgs/Float32") as recorder:
        commands = _commands(stack, str(file), f"_rate:={rate:g}")
        with session.up(*commands, environment=session.in_group(group)) as pids:
            recorder.wait()
            yield Pair(pids, pids, lambda: record.read(file), recorder.samples)


@contextlib.contextmanager
def _up_rclpy(session: Session, file: pathlib.Path, rate: float) -> Iterator[Pair]:
    seen = file.with_suffix(".seen")
    commands = [
        rclpy_peer("pair.py", "observer", str(seen)),
        rclpy_peer("pair.py", "process"),
        rclpy_peer("pair.py", "generator", str(file), f"{rate:g}"),
    ]
    with session.up(*commands, environment=rclpy_environment()) as pids:
        wait_until(lambda: record.read(seen), 30.0, "answer from rclpy")
        yield Pair(pids, pids[1:], lambda: record.read(file), lambda: record.read(seen))
