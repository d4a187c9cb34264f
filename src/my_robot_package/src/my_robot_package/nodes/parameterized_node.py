"""Node with a callback for parameter changes."""

import rospy

from my_robot_package.robot_parameters import RobotParameters
from nodekit import Node, run


class ParameterizedNode:
    """Logs the speed limit of its robot, at startup and after each change.

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.RobotParameters`
    """

    def __init__(self, node: Node) -> None:
        values = node.declare_parameters(RobotParameters, on_change=self.on_change).values
        mode = "on" if values.safety_mode else "off"
        rospy.loginfo("%s: up to %s m/s, safety %s", values.robot_name, values.max_velocity, mode)

    def on_change(self, new: RobotParameters, old: RobotParameters) -> None:
        """Log a new velocity; the values have already been validated."""
        if new.max_velocity != old.max_velocity:
            rospy.loginfo("Max velocity updated to: %s", new.max_velocity)


def main() -> None:
    """Run the node until it is shut down."""
    run("parameterized_node", ParameterizedNode)
