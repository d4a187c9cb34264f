"""The listener: logs what it hears."""

import rospy
from std_msgs.msg import String

from nodekit.messaging.stream_log import StreamLog
from nodekit.process.run import run


class Listener:
    """Logs each message with its publisher's name, of a quick stream a part.

    :ROS Subscribers:
        - ``chatter`` (std_msgs/String)
    """

    def __init__(self) -> None:
        self._log = StreamLog()
        rospy.Subscriber("chatter", String, self._on_chatter, tcp_nodelay=True)

    def _on_chatter(self, message: String) -> None:
        publisher = message._connection_header["callerid"]
        self._log.line("I heard '%s' from %s" % (message.data, publisher))


def main() -> None:
    """Run the node until it is shut down."""
    run("listener", Listener)
