"""Live parameters of the PID controller node: gains, output limits, anti-windup, timeouts."""

from nodekit import BoolParameter, EnumParameter, FloatParameter, ParameterSet, rule
from pid_control.controller.pid import ANTI_WINDUPS, CLAMPING, MODES, PI, PidSettings


class ControllerParameters(ParameterSet):
    """Parameters of the controller, all live; a change does not make the output jump."""

    mode = EnumParameter(
        PI, choices=MODES, help="which terms are used; manual: manual_output goes out"
    )
    enabled = BoolParameter(True, help="false sends an output of 0")
    kp = FloatParameter(
        0.08, minimum=-1e6, maximum=1e6, help="proportional gain: output for each unit of error"
    )
    ki = FloatParameter(
        1.5,
        minimum=-1e6,
        maximum=1e6,
        unit="1/s",
        help="integral gain: output for each unit of error and second",
    )
    kd = FloatParameter(
        0.0,
        minimum=-1e6,
        maximum=1e6,
        unit="s",
        help="derivative gain: output for each unit that the measurement changes a second",
    )
    filter_time = FloatParameter(
        0.01, minimum=0.0, maximum=1e3, unit="s", help="time constant of the derivative's filter"
    )
    set_point_weight = FloatParameter(
        1.0, minimum=0.0, maximum=1.0, help="share of the set point in the proportional term"
    )
    feed_forward = FloatParameter(
        0.0, minimum=-1e6, maximum=1e6, help="output for each unit of set point"
    )
    output_min = FloatParameter(-1.0, minimum=-1e6, maximum=1e6, help="least output")
    output_max = FloatParameter(1.0, minimum=-1e6, maximum=1e6, help="largest output")
    dead_zone = FloatParameter(
        0.0,
        minimum=0.0,
        maximum=1e6,
        help="output that does not move the plant yet; added to each output",
    )
    anti_windup = EnumParameter(
        CLAMPING,
        choices=ANTI_WINDUPS,
        help="anti-windup: limits the integral while the output is limited",
    )
    tracking_time = FloatParameter(
        0.1,
        above=0.0,
        maximum=1e3,
        unit="s",
        help="back_calculation: time constant with which the integral follows the limited output",
    )
    manual_output = FloatParameter(0.0, minimum=-1e6, maximum=1e6, help="output in the mode manual")
    timeout = FloatParameter(
        0.5,
        minimum=0.01,
        maximum=60.0,
        unit="s",
        help="longest time without a measurement, then 0 goes out; by ROS time",
    )

    command_timeout = FloatParameter(
        1.0,
        minimum=0.0,
        maximum=1e6,
        unit="s",
        help="longest time without a set point, then 0 goes out; by ROS time; 0 for ever",
    )

    @rule("output_min", "output_max")
    def _limits_are_in_order(self) -> None:
        if self.output_min >= self.output_max:
            raise ValueError("output_min must be below output_max")

    @property
    def pid(self) -> PidSettings:
        """The settings of :class:`.Pid`."""
        return PidSettings(**{name: getattr(self, name) for name in PidSettings._fields})
