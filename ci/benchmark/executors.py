"""What a call by an executor costs, with work always waiting, and how late one comes to it."""

import json
import statistics
import subprocess
import threading
import time
from typing import Any, Dict, List

from context import Bench, Figures
from peers import SCRIPTS, rclpy_environment
from stacks import RCLPY

from nodekit import MultiThreadedExecutor, SingleThreadedExecutor
from nodekit.groups.groups import Group, ReentrantGroup
from nodekit.groups.ready_queue import CallQueue, ReadyQueue

CALLS = 50_000
HOPS = 300
#: threads of the executors with several
THREADS = 2
#: longest time for all calls, s
LIMIT = 120.0


def call(bench: Bench, subject: str) -> Figures:
    """Measure executors, of one thread and of several."""
    return _rclpy(bench) if subject == RCLPY else _ours()


def _ours() -> Figures:
    figures: Dict[str, float] = {}
    single, multi = SingleThreadedExecutor(), MultiThreadedExecutor(THREADS)
    figures["single_us"] = _cpu_of_a_call(single._ready, Group())
    figures["multi_us"] = _cpu_of_a_call(multi._ready, ReentrantGroup())
    figures["hop_us"] = _hop(SingleThreadedExecutor()._ready)
    for executor in (single, multi):
        executor.shutdown()
    return figures


def _cpu_of_a_call(ready: ReadyQueue, group: Group) -> float:
    """Return the processor time of a call from its arrival to its end, us; all arrive before."""
    filled, done = threading.Event(), threading.Event()
    left = [CALLS]

    def run(things: List[Any]) -> None:
        filled.wait(LIMIT)
        if things[0] == CALLS - 1:
            done.set()

    calls = CallQueue(ready, group, CALLS, run, lambda thing: left.clear())
    began = time.process_time()
    for number in range(CALLS):
        calls.put(number)
    filled.set()
    if not done.wait(LIMIT) or not left:
        raise RuntimeError("calls were lost")
    return (time.process_time() - began) / CALLS * 1e6


def _hop(ready: ReadyQueue) -> float:
    """Return the median time from an arrival to its call while the threads are idle, us."""
    delays: List[float] = []
    called = threading.Event()

    def run(things: List[float]) -> None:
        delays.append(time.perf_counter() - things[0])
        called.set()

    calls = CallQueue(ready, Group(), 1, run, lambda thing: None)
    for _ in range(HOPS):
        called.clear()
        calls.put(time.perf_counter())
        called.wait(LIMIT)
        time.sleep(0.001)
    return statistics.median(delays) * 1e6


def _rclpy(bench: Bench) -> Figures:
    command = [str(bench.peers.rclpy), str(SCRIPTS / "ros2" / "executors.py"), str(THREADS)]
    environment = rclpy_environment()
    done = subprocess.run(
        command, env=environment, stdout=subprocess.PIPE, timeout=LIMIT, check=True
    )
    figures: Figures = json.loads(done.stdout)
    return figures
