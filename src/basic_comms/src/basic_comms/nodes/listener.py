"""Listener node: logs the messages of a topic."""

from std_msgs.msg import String

from nodekit import Node, run


class Listener:
    """Logs each message with its publisher's name; of a fast stream, some messages.

    :ROS Subscribers:
        - ``chatter`` (std_msgs/String)
    """

    def __init__(self, node: Node) -> None:
        self._log = node.create_rate_limited_log()
        node.create_subscription("chatter", String, self._on_chatter)

    def _on_chatter(self, message: String) -> None:
        publisher = message._connection_header["callerid"]
        self._log.line(f"I heard '{message.data}' from {publisher}")


def main() -> None:
    """Run the node until it is shut down."""
    run("listener", Listener)
