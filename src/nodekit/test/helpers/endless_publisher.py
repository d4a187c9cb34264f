#!/usr/bin/env python3
"""Publish from several threads until well after the node has been shut down."""

import threading

import rospy
from std_msgs.msg import String

from nodekit.messaging.publisher import Publisher


def publish_on(publisher: Publisher, stop: threading.Event) -> None:
    """Publish without pause.

    :param publisher: where to
    :param stop: ends it
    """
    while not stop.is_set():
        publisher.publish(String("x" * 1000))


def main() -> None:
    """Run until interrupted, then print that nothing was raised."""
    rospy.init_node("endless_publisher")
    publisher = Publisher(rospy.resolve_name("topic"), String)
    publisher.open()
    stop = threading.Event()
    threads = [threading.Thread(target=publish_on, args=(publisher, stop)) for _ in range(2)]
    for thread in threads:
        thread.start()
    try:
        rospy.spin()
        survivors = [thread for thread in threads if thread.is_alive()]
    finally:
        stop.set()
    for thread in threads:
        thread.join()
    print("survived" if survivors == threads else "died", flush=True)


if __name__ == "__main__":
    main()
