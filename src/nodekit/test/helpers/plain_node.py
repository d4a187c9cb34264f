#!/usr/bin/env python3
"""Run a plain rospy node with the publishers and subscribers in its arguments.

Such as ``plain_node.py talker + /chatter std_msgs/String - /speed std_msgs/Int32``. A topic named
``/drifted`` has an older definition, with another checksum.
"""

import sys
import time
from typing import Any, List

import genpy
import roslib.message
import rospy


def main() -> None:
    """Publish ten messages a second on each topic, stamped by the wall clock, until the end."""
    name, *words = rospy.myargv()[1:]
    rospy.init_node(name)
    publishers: List[Any] = []
    for sign, topic, kind in zip(words[::3], words[1::3], words[2::3]):
        message_class: Any = roslib.message.get_message_class(kind)
        if topic == "/drifted" and sign == "+":
            message_class = type("Older", (message_class,), {"_md5sum": "0" * 32})
        if sign == "-":
            rospy.Subscriber(topic, message_class)
        else:
            publishers.append(rospy.Publisher(topic, message_class, queue_size=1))
    while not rospy.is_shutdown():
        for publisher in publishers:
            message = publisher.data_class()
            if hasattr(message, "stamp"):
                message.stamp = genpy.Time.from_sec(time.time())
            publisher.publish(message)
        time.sleep(0.1)


if __name__ == "__main__":
    sys.exit(main())
