"""Many groups of generator and process: 32, and a thousand."""

import pathlib
import time
from typing import List

from . import stacks
from .context import Bench, Figures
from .cost import cpu_share, descendants, resident_memory
from .observers import Counter, wait_until
from .peer_programs import SCRIPTS
from .processes import SETTLED
from .tcpros import Node

RATE = 10.0
#: A group holds its rate if it is off by no more than this share.
TOLERANCE = 0.02
#: longest time for the start, s
LIMIT = 120.0


def thirty_two(bench: Bench, stack: str) -> Figures:
    """Start 32 groups: in one process, or the course's nodes as they are."""
    topics = [f"/Group{number}/proc_signal" for number in range(1, 33)]
    with bench.session.node() as node:
        counter = Counter(node)
        for topic in topics:
            counter.watch(topic, "std_msgs/Float32")
        began = time.monotonic()
        with bench.session.running(_command(bench, stack, 32)) as pids:
            wait_until(lambda: len(counter.first) == len(topics), LIMIT, "answer of all groups")
            up = max(counter.first.values()) - began
            time.sleep(1.0)
            nodes = pids if stack == stacks.OURS else descendants(pids[0])
            cpu = cpu_share(nodes, bench.seconds(3.0, 2.0))
            return {"up_s": up, "cpu_percent": cpu, "resident_mb": resident_memory(nodes)}


def thousand(bench: Bench, stack: str) -> Figures:
    """Start 1000 groups; count all their answers and watch the load, with and without observer."""
    topics = [f"/Group{number}/proc_signal" for number in range(1, 1001)]
    seconds = bench.seconds(5.0, 3.0)
    began = time.monotonic()
    with bench.session.running(_command(bench, stack, len(topics))) as pids:
        with bench.session.node() as node:
            wait_until(lambda: _published(node, topics), LIMIT, "sign of all groups")
            # Their timers start together, when all else is open.
            one = Counter(node)
            one.watch(topics[-1], "std_msgs/Float32")
            wait_until(lambda: bool(one.first), LIMIT, "first answer")
            up = time.monotonic() - began
        time.sleep(2.0)
        alone = cpu_share(pids, seconds)
        with bench.session.node() as node:
            counter = Counter(node)
            for topic in topics:
                counter.watch(topic, "std_msgs/Float32")
            wait_until(lambda: len(counter.first) == len(topics), LIMIT, "answer of all groups")
            time.sleep(SETTLED)  # a thousand connections have held up samples, which still come
            before, start = counter.counts(), time.monotonic()
            watched = cpu_share(pids, seconds)
            after, lasted = counter.counts(), time.monotonic() - start
        rates = [(after[topic] - before[topic]) / lasted for topic in topics]
        # A window cuts off up to one message at either end.
        slack = TOLERANCE * RATE + 1.0 / lasted
        return {
            "up_s": up,
            "holding": sum(abs(rate - RATE) <= slack for rate in rates),
            "lowest_hz": min(rates),
            "cpu_percent": alone,
            "cpu_observed_percent": watched,
            "resident_mb": resident_memory(pids),
        }


def _command(bench: Bench, stack: str, count: int) -> List[str]:
    if stack == stacks.OURS:
        return stacks.ours("fleet", f"_count:={count}", "_prefix:=Group")
    return ["roslaunch", str(_course_launch_file(bench.session.directory, count))]


def _course_launch_file(directory: pathlib.Path, count: int) -> pathlib.Path:
    include = "<include ns='Group%%d' file='%s'/>\n" % (SCRIPTS / "course" / "course.launch")
    groups = "".join(include % number for number in range(1, count + 1))
    file = directory / "course_groups.launch"
    file.write_text(f"<launch>\n{groups}</launch>\n")
    return file


def _published(node: Node, topics: List[str]) -> bool:
    publishers, _, _ = node.master("getSystemState")
    time.sleep(0.2)  # an answer about thousands of topics is work for the master
    return set(topics) <= {topic for topic, _ in publishers}
