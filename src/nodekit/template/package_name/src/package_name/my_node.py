"""A node to begin with."""

from std_msgs.msg import String

from nodekit import Node, ParameterSet, RateParameter, StringParameter, run


class MyNodeParameters(ParameterSet):
    """Parameters of my_node: they can be changed while it runs."""

    rate = RateParameter(1.0, pausable=True, help="messages a second; 0 for none")
    text = StringParameter("Hello", help="what it says")


class MyNode:
    """Says its text again and again.

    :ROS Publishers:
        - ``output`` (std_msgs/String)

    :ROS Parameters:
        - those of :class:`MyNodeParameters`, private and live
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.parameters(MyNodeParameters)
        self._publisher = node.publisher("output", String)
        node.every(lambda: self._parameters.values.rate, self.speak)

    def speak(self, elapsed: float) -> None:
        """Say it once.

        :param elapsed: time since the first call, s
        """
        self._publisher.publish(self._parameters.values.text)


def main() -> None:
    """Run the node until it is shut down."""
    run("my_node", MyNode)
