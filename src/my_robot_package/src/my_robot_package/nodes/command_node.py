"""Publisher of a message of the user's own package."""

from typing import Sequence

from geometry_msgs.msg import Point

from my_robot_package_interfaces.msg import RobotCommand
from nodekit import FloatParameter, ListParameter, Node, ParameterSet, StringParameter, run


class CommandNodeParameters(ParameterSet):
    """Parameters of command_node: the command to send."""

    command_type = StringParameter("move_to", help="action at the target")
    target_position = ListParameter(
        [0.0, 0.0, 0.0],
        element=FloatParameter(0.0, help="a coordinate"),
        min_length=3,
        max_length=3,
        unit="m",
        help="x, y and z of the target",
    )
    velocity = FloatParameter(0.5, minimum=0.0, maximum=100.0, unit="m/s", help="speed on the way")


class CommandNode:
    """Sends the command in its parameters, at the start and after each change.

    :ROS Publishers:
        - ``robot_command`` (my_robot_package_interfaces/RobotCommand), latched

    :ROS Parameters:
        - private, can be changed at run time: see :class:`CommandNodeParameters`
    """

    def __init__(self, node: Node) -> None:
        self._publisher = node.create_publisher("robot_command", RobotCommand, latch=True)
        self.on_change(
            node.declare_parameters(CommandNodeParameters, on_change=self.on_change).values
        )

    def on_change(self, new: CommandNodeParameters, *old: CommandNodeParameters) -> None:
        """Send the command in the parameters."""
        self.send_command(new.command_type, new.target_position, new.velocity)

    def send_command(
        self, command_type: str, target_position: Sequence[float], velocity: float
    ) -> None:
        """Send a command.

        :param command_type: action at the target
        :param target_position: x, y and z [m]
        :param velocity: speed on the way [m/s]
        """
        self._publisher.publish(RobotCommand(command_type, Point(*target_position), velocity))


def main() -> None:
    """Run the node until it is shut down."""
    run("command_node", CommandNode)
