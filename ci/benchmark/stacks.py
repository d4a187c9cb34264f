"""The stacks that are compared: a generator, a process and an observer of each make."""

import itertools
import pathlib
import subprocess
import sys
import time
from typing import Dict, List, NamedTuple, Optional, Tuple

import record
from analysis import Sample
from cost import cpu_share
from observers import Recorder, wait_until
from peers import HERE, SCRIPTS, WORKSPACE, Peers, rclpy_environment
from processes import Session

OURS, ROSCPP, RELAY, RCLPY, COURSE = "basic_comms", "roscpp", "relay", "rclpy", "course"
#: rclpy with its experimental EventsExecutor in place of its ``spin``.
RCLPY_EVENTS = "rclpy_events"
#: The workspace's own, with a process node that is managed, and active.
MANAGED = "managed"

EXECUTABLES = WORKSPACE / "devel" / "lib" / "basic_comms"

_numbers = itertools.count(1)


class Run(NamedTuple):
    """What a stack did in a run."""

    sent: List[Sample]
    received: List[Sample]
    #: of generator and process together, % of one core
    cpu: float
    #: when the nodes were asked to end, s
    until: float


def available(peers: Peers) -> List[str]:
    """Return the names of the stacks that can be run."""
    return [name for name in (OURS, ROSCPP, RELAY, RCLPY, COURSE) if name not in peers.left_out]


def ours(executable: str, *arguments: str) -> List[str]:
    """Return the command of one of the workspace's own nodes."""
    return [str(EXECUTABLES / executable), *arguments]


def peer(script: str, *arguments: str) -> List[str]:
    """Return the command of one of the scripts in peers."""
    return [sys.executable, str(SCRIPTS / script), *arguments]


def process_command(peers: Peers, stack: str) -> List[str]:
    """Return the command of a stack's process node."""
    if stack == OURS:
        return ours("process.py")
    if stack == MANAGED:
        return ours("process.py", "_managed:=true")
    if stack == ROSCPP:
        return [str(peers.roscpp / "process")]
    if stack == RELAY:
        return [str(peers.relay), "signal", "proc_signal", "__name:=process"]
    return peer("course/process.py")


def generator_command(peers: Peers, stack: str, file: pathlib.Path, rate: float) -> List[str]:
    """Return the command of a stack's generator, which records when it publishes.

    The relay has the workspace's own, since topic_tools brings none.
    """
    if stack == ROSCPP:
        return [str(peers.roscpp / "generator"), str(file), f"_rate:={rate:g}"]
    if stack == COURSE:
        return peer("course/signal_generator.py", str(file), f"_rate:={rate:g}")
    return peer("recorded_generator.py", str(file), f"_rate:={rate:g}")


def output_type(stack: str) -> str:
    """Return the type of a stack's proc_signal."""
    return "basic_comms/signal_msg" if stack == RELAY else "std_msgs/Float32"


def run(
    session: Session,
    peers: Peers,
    stack: str,
    rate: float,
    seconds: float,
    warm_up: float,
    course_parameters: Optional[Dict[str, float]] = None,
) -> Run:
    """Run a stack from start to end.

    :param rate: of the generator, Hz
    :param seconds: how long it is measured, s
    :param warm_up: how long it runs before that, s
    :param course_parameters: global parameters for the course's nodes
    """
    file = session.directory / f"record-{next(_numbers)}"
    if stack in (RCLPY, RCLPY_EVENTS):
        environment = rclpy_environment(events=stack == RCLPY_EVENTS)
        received, cpu, until = _run_rclpy(session, peers, environment, file, rate, seconds, warm_up)
    else:
        group = f"/run{next(_numbers)}"
        with session.node() as node, session.in_group(group):
            for name, value in (course_parameters or {}).items():
                node.master("setParam", name, value)
            recorder = Recorder(node, group + "/proc_signal", output_type(stack))
            commands = [
                process_command(peers, stack),
                generator_command(peers, stack, file, rate),
            ]
            with session.running(*commands) as pids:
                if stack == MANAGED:
                    _activate(session, group + "/process")
                recorder.wait()
                time.sleep(warm_up)
                cpu = cpu_share(pids, seconds)
                until = time.monotonic()
            received = recorder.samples()
            for name in course_parameters or {}:
                node.master("deleteParam", name)
    return Run(record.read(file), received, cpu, until)


def _activate(session: Session, node: str) -> None:
    session.wait_for(node)
    for transition in ("configure", "activate"):
        command = ["rosrun", "nodekit", "lifecycle", "set", node, transition]
        subprocess.run(command, env=session.environment, check=True, stdout=subprocess.DEVNULL)


def _run_rclpy(
    session: Session,
    peers: Peers,
    environment: Dict[str, str],
    file: pathlib.Path,
    rate: float,
    seconds: float,
    warm_up: float,
) -> Tuple[List[Sample], float, float]:
    python = str(peers.rclpy)
    environment = dict(environment, PYTHONPATH=str(HERE))
    seen = file.with_suffix(".seen")
    commands = [
        [python, str(SCRIPTS / "ros2" / "observer.py"), str(seen)],
        [python, str(SCRIPTS / "ros2" / "process.py")],
        [python, str(SCRIPTS / "ros2" / "generator.py"), str(file), f"{rate:g}"],
    ]
    running: List["subprocess.Popen[bytes]"] = []
    try:
        for command in commands:
            running.append(session.start(command, environment))
        wait_until(seen.with_suffix(".first").exists, 30.0, "answer from rclpy")
        time.sleep(warm_up)
        cpu = cpu_share([process.pid for process in running[1:]], seconds)
        until = time.monotonic()
    finally:
        session.stop(*reversed(running))
    return record.read(seen), cpu, until
