"""What was heard of a plant that is not the judge's own."""

from bisect import bisect_left
from typing import List, NamedTuple, Tuple

from pid_control.judging.record import Row
from pid_control.judging.scenarios import Scenario, value_at

#: A speed is the mean of what was measured in this time up to it, s: an encoder is coarse, and its
#: steps are no errors of the controller.
_MEAN_S = 0.04


class PlantLog(NamedTuple):
    """What was heard, each with its moment by one clock, s.

    :ivar outputs: moment, speed of the plant, and its latest input
    :ivar inputs: moment, and what the controller sent
    """

    outputs: List[Tuple[float, float, float]]
    inputs: List[Tuple[float, float]]


def rows_of(heard: PlantLog, scenario: Scenario, zero: float, scale: float) -> List[Row]:
    """Return the moments of a scenario, as of a motor of the course's greatest speed.

    :param heard: what was heard
    :param scenario: what was asked for
    :param zero: when it began, by the clock of what was heard, s
    :param scale: how many times faster than the course's motor the plant can be
    """
    moments = [moment for moment, _, _ in heard.outputs]
    rows = []
    for index, (moment, _, given) in enumerate(heard.outputs):
        time = moment - zero
        if 0.0 <= time < scenario.duration:
            latest = heard.outputs[bisect_left(moments, moment - _MEAN_S) : index + 1]
            speed = sum(speed for _, speed, _ in latest) / len(latest)
            rows.append(Row(time, value_at(scenario.set_point, time), speed / scale, given))
    return rows


def answers_of(heard: PlantLog, zero: float) -> List[Tuple[float, float]]:
    """Return the time in the scenario, s, and the input of each answer.

    :param heard: what was heard
    :param zero: when the scenario began, by the clock of what was heard, s
    """
    return [(moment - zero, value) for moment, value in heard.inputs]
