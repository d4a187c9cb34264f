"""The closed loop of motor and controller at 1 kHz, against generator and process node."""

import contextlib
import itertools
from typing import Callable, Iterator

from . import latency, record, stacks
from .analysis import Matched
from .context import Bench, Figures
from .peer_programs import executable, peer
from .processes import paused, resumed

LOOP = "pid_control"
RATE = 1000.0
_numbers = itertools.count(1)


@contextlib.contextmanager
def prepare(bench: Bench, subject: str) -> Iterator[Callable[[], Figures]]:
    """Measure the time from an output of the motor to its next input, and both nodes' cost."""
    if subject != LOOP:
        with latency.at(RATE)(bench, subject) as turn:
            yield turn
        return
    session, number = bench.session, next(_numbers)
    file, group = session.directory / f"loop-{number}", f"/loop{number}"
    environment = session.in_group(group)
    # One set point is enough, and not part of the comparison.
    set_point = executable("pid_control", "set_point_generator.py", "_rate:=1.0", "_offset:=5.0")
    system = peer("recorded.py", str(file), "time", "pid_control.nodes.system:System")
    with contextlib.ExitStack() as stack:
        recorder = stack.enter_context(
            session.record(group + "/motor_input", "pid_control/motor_input")
        )
        others = stack.enter_context(session.up(set_point, environment=environment))
        controller = executable("pid_control", "controller.py")
        pids = stack.enter_context(session.up(controller, system, environment=environment))
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
