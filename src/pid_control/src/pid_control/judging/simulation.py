"""Offline simulation of a scenario with a known control law in place of a controller node."""

import math
from typing import Callable, List

from pid_control.controller.pid import PI, Pid, PidSettings
from pid_control.judging.experiment import Experiment, MotorOutput
from pid_control.judging.record import Pause, Record
from pid_control.judging.scenarios import Scenario

#: Returns the input for a set point and an output.
Law = Callable[[float, MotorOutput], float]
#: Time of the loop before a scenario begins [s], and length of a simulated pause [s].
_SETTLE_S, _PAUSE_S = 0.1, 0.25


def simulate(scenario: Scenario, law: Law, period: float = 0.0) -> Record:
    """Run a scenario with a law that gets only finite values.

    :param scenario: the scenario
    :param law: the law
    :param period: period of the controller [s]; 0 to answer each output
    """
    experiment = Experiment(scenario, -_SETTLE_S)
    experiment.begin_at(0.0)
    answers, now, due, set_point = [], -_SETTLE_S, -_SETTLE_S, 0.0
    while now < scenario.duration:
        sent = experiment.send(now)
        if sent.set_point is not None and math.isfinite(sent.set_point):
            set_point = sent.set_point
        is_due = now >= due - 1e-6
        if is_due and sent.output is not None and math.isfinite(sent.output.speed):
            due = now + period
            answers.append((experiment.time_at(now), law(set_point, sent.output)))
            experiment.answer(now, answers[-1][1])
        now += experiment.step_after(now)
    pauses = [
        Pause(time, _PAUSE_S * (index + 1), 1.0, 0) for index, time in enumerate(scenario.pauses)
    ]
    return Record(scenario, rows=experiment.rows, answers=answers, pauses=pauses)


def pid_law(settings: PidSettings) -> Law:
    """Return the law of the reference controller, with dt from the outputs' times.

    :param settings: the settings
    """
    law = Pid(settings)
    times: List[float] = []

    def answer(set_point: float, output: MotorOutput) -> float:
        dt = output.time - times[-1] if times and output.time > times[-1] else 0.0
        times.append(output.time)
        return law.update(set_point, output.speed, dt).output

    return answer


def pi_law(gain: float, growth: float, least: float, largest: float) -> Law:
    """Return a PI law that keeps its limits and does not wind up.

    :param gain: kp [1/(rad/s)]
    :param growth: ki [1/rad]
    :param least: lower limit of the input
    :param largest: upper limit of the input
    """
    settings = PidSettings(mode=PI, kp=gain, ki=growth, output_min=least, output_max=largest)
    return pid_law(settings)
