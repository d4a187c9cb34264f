"""Managed nodes: whether they do what rclpy's do, and how long a transition takes."""

import json
import pathlib
import subprocess
import sys
from typing import Any, Dict, List

from . import transitions
from .context import Bench, Figures
from .peer_programs import SCRIPTS, WORKSPACE, rclpy_environment

#: Longest time for all that one program does, s.
LIMIT = 120.0


def agreement(bench: Bench, subject: str) -> Figures:
    """Count the cases in which nodekit's managed nodes do what rclpy's do."""
    ours = _printed(sys.executable, SCRIPTS / "transition_observer.py", bench.session.environment)
    environment = dict(rclpy_environment(), PYTHONPATH=str(WORKSPACE))
    theirs = _printed(
        str(bench.peers.rclpy), SCRIPTS / "ros2" / "transition_observer.py", environment
    )
    agree = 0
    for name in transitions.cases():
        if ours[name] == theirs[name]:
            agree += 1
        else:
            _show(name, ours[name], theirs[name])
    return {"agree": float(agree)}


def _show(name: str, ours: List[Any], theirs: List[Any]) -> None:
    for one, other in zip(ours, theirs):
        if one != other:
            print(f"{name}:\n  nodekit: {one}\n  rclpy:   {other}", file=sys.stderr)


def request(bench: Bench, subject: str) -> Figures:
    """Measure transitions without callbacks, by a client that looks the service up each time."""
    session = bench.session
    with session.running([sys.executable, str(SCRIPTS / "managed_node.py")]):
        session.wait_for("/managed")
        asking = SCRIPTS / "transition_client.py"
        figures: Figures = _printed(sys.executable, asking, session.environment)
    return figures


def _printed(python: str, script: pathlib.Path, environment: Dict[str, str]) -> Any:
    """Return what a program has printed last, as JSON."""
    command = [python, str(script)]
    done = subprocess.run(
        command,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        timeout=LIMIT,
        check=True,
    )
    return json.loads(done.stdout.splitlines()[-1])
