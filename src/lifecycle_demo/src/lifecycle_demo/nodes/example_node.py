"""Node that logs its names, and lines at five levels."""

import rospy

from nodekit import Node, ParameterSet, RateParameter, run


class ExampleNodeParameters(ParameterSet):
    """Parameters of example_node."""

    rate = RateParameter(1.0, help="rate of the five log lines")


class ExampleNode:
    """Logs its names and the time once, and a line of each level periodically.

    :ROS Parameters:
        - private, can be changed at run time: see :class:`ExampleNodeParameters`
    """

    def __init__(self, node: Node) -> None:
        namespace, _, name = node.name.rpartition("/")
        rospy.loginfo("Node name: %s", name)
        rospy.loginfo("Namespace: %s", namespace or "/")
        rospy.loginfo("Fully qualified name: %s", node.name)
        rospy.loginfo("Current time: %d ns", rospy.get_rostime().to_nsec())
        settings = node.declare_parameters(ExampleNodeParameters)
        node.create_timer(lambda: settings.values.rate, self.log)

    def log(self, elapsed: float) -> None:
        """Log a line of each level; debug messages are hidden by default."""
        rospy.logdebug("Debug message")
        rospy.loginfo("Info message")
        rospy.logwarn("Warning message")
        rospy.logerr("Error message")
        rospy.logfatal("Fatal message")


def main() -> None:
    """Run the node until it is shut down."""
    run("example_node", ExampleNode)
