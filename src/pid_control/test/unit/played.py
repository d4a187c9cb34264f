"""Scenarios without ROS: a controller answers each output at once, or every few outputs."""

import math
from typing import Callable, Dict, List

from pid_control.controller.pid import PI, Pid, PidSettings
from pid_control.judging.experiment import Experiment, Output
from pid_control.judging.limits import Limits, read_limits
from pid_control.judging.record import Record
from pid_control.judging.scenarios import BY_NAME, SCENARIOS, Scenario

#: Returns the input for a set point and an output.
Law = Callable[[float, Output], float]


def pi(kp: float = 0.08, ki: float = 1.5, **settings: float) -> Callable[[], Law]:
    """Return what makes a law: our own controller's, with dt from the outputs' times."""

    def make() -> Law:
        law = Pid(PidSettings(mode=PI, kp=kp, ki=ki)._replace(**settings))
        times: List[float] = []

        def answer(set_point: float, output: Output) -> float:
            dt = output.time - times[-1] if times and output.time > times[-1] else 0.0
            times.append(output.time)
            return law.update(set_point, output.speed, dt).output

        return answer

    return make


def play(scenario: Scenario, law: Law) -> Record:
    """Run a scenario with a law that leaves out what is not a number."""
    experiment = Experiment(scenario, -0.1)
    experiment.begin_at(0.0)
    answers, now, set_point = [], -0.1, 0.0
    while now < scenario.duration:
        sent = experiment.send(now)
        if sent.set_point is not None and math.isfinite(sent.set_point):
            set_point = sent.set_point
        if sent.output is not None and math.isfinite(sent.output.speed):
            answers.append((now, law(set_point, sent.output)))
            experiment.answer(*answers[-1])
        now += experiment.step_after(now)
    return Record(scenario, rows=experiment.rows, answers=answers, standstill_rest=1.0)


def play_all(make: Callable[[], Law]) -> List[Record]:
    """Run all scenarios, each with a law of its own."""
    return [play(scenario, make()) for scenario in SCENARIOS]


def play_one(name: str, make: Callable[[], Law]) -> Record:
    """Run one scenario."""
    return play(BY_NAME[name], make())


def default_limits() -> Limits:
    """Return the limits that the package brings."""
    import pathlib

    place = pathlib.Path(__file__).resolve().parents[2] / "config" / "judge_limits.yaml"
    return read_limits(place.read_text("utf-8"))


def only(limits: Dict[str, float], scenario: str) -> Limits:
    """Return limits for one scenario."""
    return {scenario: dict(limits)}
