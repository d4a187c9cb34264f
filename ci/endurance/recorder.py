"""Record topics in a bag, without a queue, until Ctrl-C: recorder.py BAG TOPIC…

``rosbag record`` keeps at most 100 messages of a topic waiting and drops what is more, which at
1 kHz is a tenth of a second. Here the kernel's buffers are what waits, and they hold minutes.
"""

import threading
from typing import Any, List

import rosbag
import rospy
from roslib.message import get_message_class

from nodekit import Subscription


class Recorder:
    """Writes what it hears into a bag.

    :param bag: open for writing
    """

    def __init__(self, bag: rosbag.Bag) -> None:
        self._bag = bag
        self._one_at_a_time = threading.Lock()
        self._open = True

    def record(self, topic: str) -> None:
        """Record a topic from now on."""
        Subscription(
            rospy.resolve_name(topic),
            rospy.AnyMsg,
            lambda messages, may_wait: self._write(topic, messages),
        ).open()

    def close(self) -> None:
        """Write no more."""
        with self._one_at_a_time:
            self._open = False

    def _write(self, topic: str, messages: List[Any]) -> None:
        with self._one_at_a_time:
            for message in messages if self._open else []:
                header = message._connection_header
                kind = header["type"]
                raw = (kind, message._buff, header["md5sum"], get_message_class(kind))
                self._bag.write(topic, raw, raw=True)


def main(path: str, *topics: str) -> None:
    """Record until the node is shut down."""
    rospy.init_node("record")
    with rosbag.Bag(path, "w") as bag:
        recorder = Recorder(bag)
        for topic in topics:
            recorder.record(topic)
        rospy.spin()
        recorder.close()


if __name__ == "__main__":
    main(*rospy.myargv()[1:])
