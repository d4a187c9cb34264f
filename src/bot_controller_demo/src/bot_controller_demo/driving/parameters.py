"""Parameters of driving to a goal, under the course's names."""

from bot_controller_demo.control.goal_controller import Tuning
from bot_controller_demo.control.steering import LAWS, Gains
from bot_controller_demo.control.velocities import Limits
from nodekit import EnumParameter, FloatParameter, ParameterSet, RateParameter, read_once, rule

#: Message types, by the course's names.
CONTROLLER_TYPES = ("rviz", "gazebo")


def controller_type() -> EnumParameter:
    """Declare the message type of the commands."""
    return read_once(
        EnumParameter(
            "rviz",
            choices=CONTROLLER_TYPES,
            help="type of cmd_vel: rviz for Twist, gazebo for TwistStamped",
        )
    )


def _gain(default: float, what: str) -> FloatParameter:
    return FloatParameter(default, above=0.0, maximum=100.0, unit="1/s", help="gain of " + what)


class DrivingParameters(ParameterSet):
    """Parameters of driving to a goal; all but the type may change while driving."""

    controller_type = controller_type()
    control_law = EnumParameter(
        "settling",
        choices=tuple(LAWS),
        help="settling reaches every goal; course may circle it unless kp_angular is about "
        "twice kp_linear",
    )
    kp_linear = _gain(0.5, "the distance")
    kp_angular = _gain(1.0, "the angle")
    linear_tolerance = FloatParameter(
        0.1, above=0.0, maximum=10.0, unit="m", help="distance at which the goal counts as reached"
    )
    angular_tolerance = FloatParameter(
        0.05,
        above=0.0,
        maximum=3.0,
        unit="rad",
        help="error of the heading at which the goal counts as reached",
    )
    control_frequency = RateParameter(20.0, maximum=1000.0, help="commands per second")
    max_linear_velocity = FloatParameter(
        0.5, above=0.0, maximum=100.0, unit="m/s", help="highest commanded speed"
    )
    max_angular_velocity = FloatParameter(
        1.0, above=0.0, maximum=100.0, unit="rad/s", help="highest commanded turning rate"
    )
    odom_timeout = FloatParameter(
        0.5,
        above=0.0,
        maximum=60.0,
        unit="s",
        help="age of the odometry at which the robot is stopped",
    )
    no_progress_timeout = FloatParameter(
        10.0,
        minimum=0.0,
        maximum=3600.0,
        unit="s",
        help="time without progress after which a goal is given up; 0 for never",
    )

    @rule("kp_linear", "kp_angular", "control_frequency")
    def is_stable(self) -> None:
        """Reject oscillating gains, for velocities held for a period and odometry a period old."""
        if max(self.kp_linear, self.kp_angular) >= self.control_frequency:
            raise ValueError("both gains must be below control_frequency, or the robot oscillates")

    @property
    def tuning(self) -> Tuning:
        """Tuning of the goal controller."""
        return Tuning(
            self.control_law,
            Gains(self.kp_linear, self.kp_angular),
            Limits(self.max_linear_velocity, self.max_angular_velocity),
            self.linear_tolerance,
            self.angular_tolerance,
        )
