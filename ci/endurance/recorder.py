"""Record topics in a bag without a queue until Ctrl-C; usage: recorder.py BAG TOPIC….

``rosbag record`` queues at most 100 messages of a topic, a tenth of a second at 1 kHz, and drops
more. Here messages wait in the kernel's buffers, which hold minutes.
"""

import threading
from typing import Any, List

import rosbag
import rospy
from roslib.message import get_message_class

from nodekit import Subscription


def main(path: str, *topics: str) -> None:
    """Record until the node is shut down."""
    rospy.init_node("record")
    lock, bag = threading.Lock(), rosbag.Bag(path, "w")

    def subscribe(topic: str) -> None:
        def write(messages: List[Any], _may_wait: object) -> None:
            with lock:
                for message in messages if not rospy.is_shutdown() else []:
                    header = message._connection_header
                    kind = header["type"]
                    raw = (kind, message._buff, header["md5sum"], get_message_class(kind))
                    bag.write(topic, raw, raw=True)

        Subscription(rospy.resolve_name(topic), rospy.AnyMsg, write).open()

    for topic in topics:
        subscribe(topic)
    rospy.spin()
    with lock:
        bag.close()


if __name__ == "__main__":
    main(*rospy.myargv()[1:])
