"""The closed loop of motor and controller at 1 kHz, against generator and process node."""

import contextlib
import itertools
from typing import Callable, Iterator

from . import latency, record, stacks
from .analysis import Matched
from .context import Bench, Figures
from .peer_programs import executable, peer
from .processes import paused, resumed
from .recorder import Recorder

LOOP = "pid_control"
RATE = 1000.0
_numbers = itertools.count(1)


@contextlib.contextmanager
def prepare(bench: Bench, stack: str) -> Iterator[Callable[[], Figures]]:
    """Measure from an output of the motor to its next input, and what both nodes cost."""
    if stack != LOOP:
        with latency.at(RATE)(bench, stack) as turn:
            yield turn
        return
    session, number = bench.session, next(_numbers)
    file, group = session.directory / f"loop-{number}", f"/loop{number}"
    environment = session.in_group(group)
    # One set point is enough, and not part of the comparison.
    set_point = executable("pid_control", "set_point_generator.py", "_rate:=1.0", "_offset:=5.0")
    commands = [executable("pid_control", "controller.py"), peer("recorded_system.py", str(file))]
    with session.node() as node:
        recorder = Recorder(node, group + "/motor_input", "pid_control/motor_input")
        with session.up(set_point, environment=environment) as others, session.up(
            *commands, environment=environment
        ) as pids:
            recorder.wait(100)
            pair = stacks.Pair([*pids, *others], pids, lambda: record.read(file), recorder.samples)
            with paused(pair.pids):
                yield lambda: _take_turn(pair)


def _take_turn(pair: stacks.Pair) -> Figures:
    with resumed(pair.pids):
        run = stacks.watch(pair, latency.SETTLE_S, latency.TURN_S)
    return latency.figures(answered(run), run)


def answered(run: stacks.Run) -> Matched:
    """Match the motor's outputs of a turn with the inputs that answer them, by their times."""
    # Before the first set point, and at the end, the controller stops the motor once.
    answers = {answer.value: answer.moment for answer in reversed(run.received)}
    outputs = [output for output in run.sent if run.since <= output.moment <= run.until]
    taken = [output for output in outputs if output.value in answers]
    return Matched(
        [output.moment for output in taken],
        [answers[output.value] - output.moment for output in taken],
        len(outputs) - len(taken),
    )
