"""A node to start from."""

from std_msgs.msg import String

from nodekit import Node, ParameterSet, RateParameter, StringParameter, run


class MyNodeParameters(ParameterSet):
    """Parameters of my_node: they can be changed while it runs."""

    rate = RateParameter(1.0, pausable=True, help="messages per second; 0 for none")
    text = StringParameter("Hello", help="the text to publish")


class MyNode:
    """Publishes its text periodically.

    :ROS Publishers:
        - ``output`` (std_msgs/String)

    :ROS Parameters:
        - those of :class:`MyNodeParameters`, private and live
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(MyNodeParameters)
        self._publisher = node.create_publisher("output", String)
        node.create_timer(lambda: self._parameters.values.rate, self.publish_text)

    def publish_text(self, elapsed: float) -> None:
        """Publish the text once.

        :param elapsed: time since the first call, s
        """
        self._publisher.publish(self._parameters.values.text)


def main() -> None:
    """Run the node until it is shut down."""
    run("my_node", MyNode)
