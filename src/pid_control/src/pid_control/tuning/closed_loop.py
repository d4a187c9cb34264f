"""Step response of the closed loop of a controller and a model."""

import math
from typing import List, NamedTuple

from first_order_sys_sim.first_order_plant import PlantSettings
from first_order_sys_sim.sampled_plant import SampledPlant
from pid_control.charts.chart import Curve, Panel, as_svg
from pid_control.controller.pid import Pid, PidSettings
from pid_control.identification.response import Model
from pid_control.plant.delayed_plant import DelayedPlant
from pid_control.tuning.rules import Gains

#: Height of the step as a share of the plant's range; duration in time constants plus dead times of
#: the plant or, if slower, of the loop; largest number of samples.
_SHARE, _LONG, _MOST = 0.5, 12.0, 200_000
#: Settling band, as a share of the step.
_NEAR = 0.02
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
_SET_POINT = "#999999"


class Response(NamedTuple):
    """Response to a step of the set point.

    :ivar gains: gains of the controller
    :ivar times: times from the step on [s]
    :ivar outputs: outputs of the plant
    :ivar inputs: inputs of the plant
    :ivar set_point: the set point after the step from 0
    """

    gains: Gains
    times: List[float]
    outputs: List[float]
    inputs: List[float]
    set_point: float

    @property
    def rise_time(self) -> float:
        """Time from 10 % to 90 % of the step [s]; infinite if not reached."""
        end = self._reached(0.9)
        return end - self._reached(0.1) if math.isfinite(end) else math.inf

    @property
    def overshoot(self) -> float:
        """Overshoot, as a share of the step."""
        return max(0.0, max(value / self.set_point for value in self.outputs) - 1.0)

    @property
    def settling_time(self) -> float:
        """Time until the output stays in the settling band [s]; infinite if it does not."""
        off = [
            time
            for time, value in zip(self.times, self.outputs)
            if abs(value / self.set_point - 1.0) > _NEAR
        ]
        latest = off[-1] if off else 0.0
        return latest if latest < self.times[-1] else math.inf

    def _reached(self, share: float) -> float:
        for time, value in zip(self.times, self.outputs):
            if value / self.set_point >= share:
                return time
        return math.inf


def respond(model: Model, gains: Gains, period: float, least: float, largest: float) -> Response:
    """Simulate the step response of the reference controller and a plant.

    :param model: the plant
    :param gains: gains of the controller
    :param period: period of the controller [s]
    :param least: lower limit of the controller's output
    :param largest: upper limit of the controller's output
    """
    plant = PlantSettings(model.gain, model.time_constant, model.limit, model.dead_zone)
    # Short compared with the plant's time constant, for any period.
    sample_time = min(period, 0.01 * model.time_constant)
    motor = DelayedPlant(SampledPlant(plant, sample_time), model.dead_time)
    settings = PidSettings(gains.mode, gains.kp, gains.ki, gains.kd, gains.filter_time)
    pid = Pid(settings._replace(output_min=least, output_max=largest))
    set_point = math.copysign(_SHARE * min(abs(model.gain) * largest, model.limit), model.gain)
    # The integral dominates a slow loop; its time constant alone is 1 / (K ki).
    loop = 1.0 / abs(model.gain * gains.ki) if gains.ki != 0.0 else 0.0
    duration = _LONG * max(model.time_constant + model.dead_time + period, loop)
    response = Response(gains, [], [], [], set_point)
    for number in range(min(math.ceil(duration / period), _MOST)):
        time = number * period
        speed = motor.output(time)
        given = pid.update(set_point, speed, period if number else 0.0).output
        motor.set_input(time, given)
        response.times.append(time)
        response.outputs.append(speed)
        response.inputs.append(given)
    return response


def as_table(responses: List[Response]) -> str:
    """Return a table of gains and responses, one method per line.

    :param responses: response of each method
    """
    lines = [
        f"{'':21}{'kp':>9}{'ki, 1/s':>9}{'kd, s':>10}{'rise, s':>9}{'overshoot':>11}"
        f"{'settled, s':>12}"
    ]
    for one in responses:
        gains = one.gains
        lines.append(
            f"{gains.method:21}{gains.kp:9.4g}{gains.ki:9.4g}{gains.kd:10.4g}"
            f"{one.rise_time:9.3g}{100.0 * one.overshoot:9.1f} %{_settled(one):>12}"
        )
    return "\n".join(lines)


def _settled(response: Response) -> str:
    time = response.settling_time
    return f"{time:.3g}" if math.isfinite(time) else f"> {response.times[-1]:.4g}"


def as_picture(responses: List[Response]) -> str:
    """Return an SVG picture of all responses.

    :param responses: response of each method; at least one
    """
    longest = max(responses, key=lambda response: len(response.times))
    asked = [longest.set_point] * len(longest.times)
    wanted = Curve("set point", _SET_POINT, longest.times, asked)
    outputs, inputs = [wanted], []
    for one, colour in zip(responses, _COLOURS):
        outputs.append(Curve(one.gains.method, colour, one.times, one.outputs))
        inputs.append(Curve("", colour, one.times, one.inputs, True))
    return as_svg([Panel("output", outputs), Panel("input", inputs, 100.0)])
