"""The closed loop of motor and controller at 1 kHz, against generator and process at that rate."""

import itertools
import time

import latency
import record
import stacks
from analysis import Matched, after_warm_up, percentile
from context import Bench, Figures
from cost import cpu_share
from observers import Recorder
from peers import WORKSPACE

LOOP = "pid_control"
EXECUTABLES = WORKSPACE / "devel" / "lib" / "pid_control"
_numbers = itertools.count(1)


def measure(bench: Bench, stack: str) -> Figures:
    """Measure how long an output of the motor takes to become its input, and what both nodes cost.

    Each input says which output it answers, so nothing is taken for granted.
    """
    if stack != LOOP:
        return latency.at_1_khz(bench, stack)
    session, seconds = bench.session, bench.seconds(2.5, 1.0)
    number = next(_numbers)
    file, group = session.directory / f"loop-{number}", f"/loop{number}"
    with session.node() as node, session.in_group(group):
        recorder = Recorder(node, group + "/motor_input", "pid_control/motor_input")
        # One set point is enough, and no part of what is compared.
        set_point = [str(EXECUTABLES / "set_point_generator.py"), "_rate:=1.0", "_offset:=5.0"]
        controller = [str(EXECUTABLES / "controller.py")]
        motor = stacks.peer("recorded_system.py", str(file))
        with session.running(set_point), session.running(controller, motor) as pids:
            recorder.wait(100)
            time.sleep(latency.WARM_UP)
            cpu = cpu_share(pids, seconds)
            until = time.monotonic()
        answers = recorder.samples()
    outputs = {sample.value: sample.moment for sample in record.read(file)}
    # Before the first set point, and at the end, the controller stops the motor once.
    answered = {answer.value: answer.moment for answer in reversed(answers)}
    pairs = sorted(
        (outputs[value], moment)
        for value, moment in answered.items()
        if value in outputs and moment <= until
    )
    if not pairs:
        raise ValueError("no output was answered")
    first = pairs[0][0]
    due = [moment for moment in outputs.values() if first <= moment <= pairs[-1][0]]
    sent, taken = [sent for sent, _ in pairs], [got - sent for sent, got in pairs]
    matched = Matched(sent, taken, len(due) - len(pairs))
    latencies = after_warm_up(matched, latency.WARM_UP)
    return {
        "p50_us": 1e6 * percentile(latencies, 0.50),
        "p90_us": 1e6 * percentile(latencies, 0.90),
        "p99_us": 1e6 * percentile(latencies, 0.99),
        "samples": len(latencies),
        "lost": matched.lost,
        "cpu_percent": cpu,
    }
