"""Subscribers that hand over at once whatever has arrived."""

from typing import Any, Callable, List

import rospy

from nodekit.rospy_internals import subscribers


class Subscriber(rospy.Subscriber):
    """A ``rospy.Subscriber`` whose callback gets all messages that have arrived together.

    Mostly that is one. After a busy moment it is many, which are then handled and answered
    together: that is what makes up for the delay. None is left out.

    :param name: topic
    :param data_class: message class
    :param callback: called with a list of messages, oldest first, from a thread for each publisher
    """

    def __init__(self, name: str, data_class: type, callback: Callable[[List[Any]], None]) -> None:
        mismatch = subscribers.subscriber_mismatch()
        if mismatch:
            rospy.logwarn_once("receiving one by one, as this rospy is not known: %s", mismatch)
        if not mismatch and subscribers.receive_in_batches(name, data_class, callback):
            super().__init__(name, data_class, tcp_nodelay=True)
        else:
            super().__init__(name, data_class, lambda one: callback([one]), tcp_nodelay=True)
