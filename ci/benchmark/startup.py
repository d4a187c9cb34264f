"""How soon the first answer is there after roslaunch, and how much memory a node takes."""

import time

from . import stacks
from .context import Bench, Figures
from .cost import resident_memory
from .observers import Recorder
from .peer_programs import SCRIPTS

LAUNCH = {
    stacks.OURS: ["basic_comms", "cw1.launch"],
    stacks.COURSE: [str(SCRIPTS / "course" / "course.launch")],
}

GENERATOR, PROCESS, BARE = "signal_generator", "process", "bare_node"


def launch(bench: Bench, stack: str) -> Figures:
    """Launch two nodes; the master and an observer are there already."""
    session = bench.session
    with session.node() as node:
        recorder = Recorder(node, "/proc_signal", "std_msgs/Float32")
        began = time.monotonic()
        with session.running(["roslaunch", *LAUNCH[stack]]):
            first = recorder.wait()
    return {"first_answer_s": first - began}


def memory(bench: Bench, node: str) -> Figures:
    """Measure a node that runs by itself, as started by default."""
    command = stacks.peer("bare_node.py") if node == BARE else stacks.ours(node + ".py")
    with bench.session.running(command) as pids:
        bench.session.wait_for("/" + node)
        return {"resident_mb": resident_memory(pids)}
