"""Random controller node: drives a robot at random."""

from std_msgs.msg import Bool

from bot_controller_demo.driving.commands import Commands
from bot_controller_demo.driving.parameters import controller_type
from bot_controller_demo.control.wandering import Wanderer
from nodekit import FloatParameter, IntParameter, Node, ParameterSet, rule, run


def _speed(default: float, help: str) -> FloatParameter:
    return FloatParameter(default, minimum=-100.0, maximum=100.0, unit="m/s", help=help)


def _rate(default: float, help: str) -> FloatParameter:
    return FloatParameter(default, minimum=-100.0, maximum=100.0, unit="rad/s", help=help)


class RandomControllerParameters(ParameterSet):
    """Parameters of random_controller."""

    controller_type = controller_type()
    linear_min = _speed(0.1, "lowest speed")
    linear_max = _speed(0.2, "highest speed")
    angular_min = _rate(-1.0, "lowest turning rate; positive is to the left")
    angular_max = _rate(1.0, "highest turning rate")
    timer_period_ms = IntParameter(
        200, minimum=1, maximum=3_600_000, unit="ms", help="time between velocities"
    )
    seed = IntParameter(
        0, minimum=0, help="seed of the velocities; 0 for a different one at each start"
    )

    @rule("linear_min", "linear_max")
    def has_speeds(self) -> None:
        """Reject an empty interval."""
        if self.linear_min > self.linear_max:
            raise ValueError("linear_min must be at most linear_max")

    @rule("angular_min", "angular_max")
    def has_rates(self) -> None:
        """Reject an empty interval."""
        if self.angular_min > self.angular_max:
            raise ValueError("angular_min must be at most angular_max")


class RandomController:
    """Publishes a new random velocity each period, and zero at the end.

    At a wall, the robot turns away in place.

    :ROS Subscribers:
        - ``contact`` (std_msgs/Bool): whether the robot touches a wall; not every robot has it

    :ROS Publishers:
        - ``cmd_vel`` (geometry_msgs/Twist, or TwistStamped)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`RandomControllerParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(RandomControllerParameters, self._on_change)
        self._wanderer = Wanderer(self._parameters.values.seed)
        self._commands = Commands(node, self._parameters.values.controller_type)
        self._has_touched = False
        node.create_subscription("contact", Bool, self._on_contact)
        node.create_timer(lambda: 1000.0 / self._parameters.values.timer_period_ms, self._drive)

    def _on_change(self, new: RandomControllerParameters, old: RandomControllerParameters) -> None:
        if new.seed != old.seed:
            self._wanderer = Wanderer(new.seed)

    def _on_contact(self, contact: Bool) -> None:
        self._has_touched = self._has_touched or contact.data

    def _drive(self, _elapsed: float) -> None:
        settings = self._parameters.values
        velocity = self._wanderer.draw(
            (settings.linear_min, settings.linear_max),
            (settings.angular_min, settings.angular_max),
            settings.timer_period_ms / 1000.0,
            self._has_touched,
        )
        self._has_touched = False
        self._commands.publish(velocity)


def main() -> None:
    """Run the node until it is shut down."""
    run("random_controller", RandomController)
