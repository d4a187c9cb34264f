"""One type for each topic: rospy takes a second one in a process for the first, without a word."""

from typing import Any

import rospy


class NameTaken(rospy.ROSException):
    """A name that this process uses for something else already; the text says which."""


def refuse_another(topic: Any, data_class: Any) -> None:
    """Refuse to use a topic with a second type.

    :param topic: rospy's implementation object of the topic; None if there is none
    :param data_class: message class
    :raises NameTaken: if that is of another type
    """
    if topic is not None:
        used, name = topic.data_class, topic.resolved_name
        if (used._type, used._md5sum) != (data_class._type, data_class._md5sum):
            why = f"must be {used._type}, as elsewhere in this process"
            raise NameTaken(f"topic {name}: refused {data_class._type}: {why}")
