"""Second node for a launch file."""

from std_msgs.msg import String

from nodekit import Node, ParameterSet, StringParameter, run


class AnotherNodeParameters(ParameterSet):
    """Parameters of another_node."""

    param1 = StringParameter("default", help="text to publish")


class AnotherNode:
    """Publishes its parameter each second.

    :ROS Publishers:
        - ``output_topic`` (std_msgs/String)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`AnotherNodeParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(AnotherNodeParameters)
        self._publisher = node.create_publisher("output_topic", String)
        node.create_timer(1.0, self.publish)

    def publish(self, elapsed: float) -> None:
        """Publish the parameter."""
        self._publisher.publish(self._parameters.values.param1)


def main() -> None:
    """Run the node until it is shut down."""
    run("another_node", AnotherNode)
