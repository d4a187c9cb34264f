"""Logged messages of a real plant, converted to the record of a scenario."""

from bisect import bisect_left
from typing import List, NamedTuple, Tuple

from pid_control.judging.record import Row
from pid_control.judging.scenarios import Scenario, value_at

#: Averaging window of the speed [s]: the steps of a coarse encoder are not control errors.
_MEAN_S = 0.04


class PlantLog(NamedTuple):
    """Messages of a plant and its controller, with times of one clock [s].

    :ivar outputs: time, speed of the plant, and its latest input
    :ivar inputs: time, and input sent by the controller
    """

    outputs: List[Tuple[float, float, float]]
    inputs: List[Tuple[float, float]]


def rows_of(log: PlantLog, scenario: Scenario, zero: float, scale: float) -> List[Row]:
    """Return the rows of a scenario, scaled to the greatest speed of the course's motor.

    :param log: messages of the plant
    :param scenario: the scenario
    :param zero: start of the scenario by the log's clock [s]
    :param scale: greatest speed of the plant over that of the course's motor
    """
    moments = [moment for moment, _, _ in log.outputs]
    rows = []
    for index, (moment, _, given) in enumerate(log.outputs):
        time = moment - zero
        if 0.0 <= time < scenario.duration:
            latest = log.outputs[bisect_left(moments, moment - _MEAN_S) : index + 1]
            speed = sum(speed for _, speed, _ in latest) / len(latest)
            rows.append(Row(time, value_at(scenario.set_point, time), speed / scale, given))
    return rows


def answers_of(log: PlantLog, zero: float) -> List[Tuple[float, float]]:
    """Return the time in the scenario [s] and the input of each answer.

    :param log: messages of the plant
    :param zero: start of the scenario by the log's clock [s]
    """
    return [(moment - zero, value) for moment, value in log.inputs]
