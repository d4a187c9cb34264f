"""The closed loop of motor and controller at 1 kHz, against generator and process at that rate."""

import contextlib
import itertools
from typing import Callable, Iterator

from . import latency, record, stacks
from .analysis import Matched
from .context import Bench, Figures
from .observers import Recorder
from .pausing import going, standing
from .peer_programs import WORKSPACE

LOOP = "pid_control"
EXECUTABLES = WORKSPACE / "devel" / "lib" / "pid_control"
RATE = 1000.0
_numbers = itertools.count(1)


@contextlib.contextmanager
def stand_ready(bench: Bench, stack: str) -> Iterator[Callable[[], Figures]]:
    """Have the loop, or generator and process, stand ready for turns.

    It is measured how long an output of the motor takes to become its input, and what both nodes
    cost. Each input says which output it answers, so nothing is taken for granted.
    """
    if stack != LOOP:
        with latency.in_turns(RATE)(bench, stack) as turn:
            yield turn
        return
    session, number = bench.session, next(_numbers)
    file, group = session.directory / f"loop-{number}", f"/loop{number}"
    environment = session.in_group(group)
    with session.node() as node:
        recorder = Recorder(node, group + "/motor_input", "pid_control/motor_input")
        # One set point is enough, and no part of what is compared.
        set_point = [str(EXECUTABLES / "set_point_generator.py"), "_rate:=1.0", "_offset:=5.0"]
        controller = [str(EXECUTABLES / "controller.py")]
        motor = stacks.peer("recorded_system.py", str(file))
        with session.running(set_point, environment=environment) as others, session.running(
            controller, motor, environment=environment
        ) as pids:
            recorder.wait(100)
            pair = stacks.Pair([*pids, *others], pids, lambda: record.read(file), recorder.samples)
            with standing(pair.pids):
                yield lambda: _turn(pair)


def _turn(pair: stacks.Pair) -> Figures:
    with going(pair.pids):
        run = stacks.watch(pair, latency.SETTLE_S, latency.TURN_S)
    return latency.figures(answered(run), run)


def answered(run: stacks.Run) -> Matched:
    """Match the outputs that were sent while a run was watched with the inputs that answer them."""
    # Before the first set point, and at the end, the controller stops the motor once.
    answers = {answer.value: answer.moment for answer in reversed(run.received)}
    outputs = [output for output in run.sent if run.since <= output.moment <= run.until]
    taken = [output for output in outputs if output.value in answers]
    return Matched(
        [output.moment for output in taken],
        [answers[output.value] - output.moment for output in taken],
        len(outputs) - len(taken),
    )
