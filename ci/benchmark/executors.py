"""What a call by an executor costs, with work always waiting, and how late one comes to it."""

import json
import subprocess
from typing import Dict

from nodekit.testing.costs import delay, processor_time

from nodekit import Group, MultiThreadedExecutor, Names, Node, SingleThreadedExecutor

from .context import Bench, Figures
from .peer_programs import SCRIPTS, rclpy_environment
from .stacks import OURS, RCLPY_EVENTS

#: threads of the executors with several
THREADS = 2
#: longest time for those of ROS 2, s
LIMIT = 120.0


def call(bench: Bench, subject: str) -> Figures:
    """Measure executors, of one thread and of several."""
    return _ours() if subject == OURS else _rclpy(bench, subject)


def _ours() -> Figures:
    figures: Dict[str, float] = {}
    single, multi = SingleThreadedExecutor(), MultiThreadedExecutor(THREADS)
    idle, node = SingleThreadedExecutor(), Node(Names("/executors", is_hosted=True))
    figures["single_us"] = processor_time(single, Group())
    figures["multi_us"] = processor_time(multi, node.group(exclusive=False))
    figures["hop_us"] = delay(idle)
    for executor in (single, multi, idle):
        executor.shutdown()
    return figures


def _rclpy(bench: Bench, subject: str) -> Figures:
    command = [str(bench.peers.rclpy), str(SCRIPTS / "ros2" / "executors.py"), str(THREADS)]
    environment = rclpy_environment(events=subject == RCLPY_EVENTS)
    done = subprocess.run(
        command, env=environment, stdout=subprocess.PIPE, timeout=LIMIT, check=True
    )
    figures: Figures = json.loads(done.stdout)
    return figures
