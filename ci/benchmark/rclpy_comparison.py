"""Executors and managed nodes beside rclpy's: cost of a call, and differences in behaviour."""

import json
import subprocess
import sys
from typing import Any, Dict, List

from nodekit import (
    Group,
    MultiThreadedExecutor,
    ReentrantCallbackGroup,
    SingleThreadedExecutor,
)

from .call_costs import delay, processor_time
from .context import Bench, Figures
from .executor_scenarios import SCENARIOS
from .lifecycle_cases import cases
from .peer_programs import peer, rclpy_environment, rclpy_peer
from .stacks import RCLPY

#: Threads of the executors with several.
THREADS = 2
#: Longest time for one program [s].
LIMIT = 120.0


def measure_executor(_bench: Bench, subject: str) -> Figures:
    """Measure a call by executors of one thread and of several, with work always waiting."""
    if subject == RCLPY:
        figures: Figures = _printed(rclpy_peer("executors.py", str(THREADS)), rclpy_environment())
        return figures
    single, multi = SingleThreadedExecutor(), MultiThreadedExecutor(THREADS)
    idle = SingleThreadedExecutor()
    figures = {
        "single_us": processor_time(single, Group()),
        "multi_us": processor_time(multi, ReentrantCallbackGroup()),
        "delay_us": delay(idle),
    }
    for executor in (single, multi, idle):
        executor.shutdown()
    return figures


def compare_overlap(bench: Bench, subject: str) -> Figures:
    """Count the scenarios in which callbacks overlap differently than expected."""
    observed = _observed(bench, subject, "observe_executors.py")
    return _differences(
        observed, {name: scenario.expected for name, scenario in SCENARIOS.items()}, subject
    )


def compare_lifecycle(bench: Bench, subject: str) -> Figures:
    """Count the cases in which nodekit's managed nodes differ from rclpy's."""
    script = "observe_lifecycle.py"
    ours, theirs = _observed(bench, "", script), _observed(bench, subject, script)
    return _differences({name: ours[name] for name in cases()}, theirs, "nodekit")


def _differences(observed: Dict[str, Any], expected: Dict[str, Any], subject: str) -> Figures:
    differing = [name for name in observed if observed[name] != expected[name]]
    for name in differing:
        print(f"{subject}, {name}: {observed[name]}, not {expected[name]}", file=sys.stderr)
    return {"cases": float(len(observed)), "differ": float(len(differing))}


def _observed(bench: Bench, subject: str, script: str) -> Any:
    """Return what a script prints, with rclpy or with nodekit."""
    if subject == RCLPY:
        return _printed(rclpy_peer(script), rclpy_environment())
    return _printed(peer(script), bench.session.environment)


def _printed(command: List[str], environment: Dict[str, str]) -> Any:
    """Return the last line that a program prints, read as JSON."""
    done = subprocess.run(
        command,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        timeout=LIMIT,
        check=True,
    )
    return json.loads(done.stdout.splitlines()[-1])
