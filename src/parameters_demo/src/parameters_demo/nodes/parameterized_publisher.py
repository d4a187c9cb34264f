"""Publisher with text and rate as parameters: the course's first exercise."""

from std_msgs.msg import String

from nodekit import Node, ParameterSet, RateParameter, StringParameter, run


class ParameterizedPublisherParameters(ParameterSet):
    """Parameters of parameterized_publisher."""

    message_prefix = StringParameter("Hello", help="start of each message")
    publish_rate = RateParameter(2.0, help="publishing rate")


class ParameterizedPublisher:
    """Publishes ``PREFIX NUMBER``, counted from 0.

    :ROS Publishers:
        - ``chatter`` (std_msgs/String)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`ParameterizedPublisherParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(ParameterizedPublisherParameters)
        self._count = 0
        self._publisher = node.create_publisher("chatter", String)
        self._log = node.create_rate_limited_log()
        node.create_timer(lambda: self._parameters.values.publish_rate, self.publish)

    def publish(self, elapsed: float) -> None:
        """Publish the next message."""
        text = f"{self._parameters.values.message_prefix} {self._count}"
        self._publisher.publish(text)
        self._count += 1
        self._log.line(f"Publishing: '{text}'")


def main() -> None:
    """Run the node until it is shut down."""
    run("parameterized_publisher", ParameterizedPublisher)
