"""Subscription that reports publishers of the wrong type.

ROS does not connect a publisher of another type: no message arrives, and the log suggests no
remedy. So the subscription accepts any type, and ignores messages of another type with a warning.
It is still registered with the expected type.
"""

from typing import Any, Callable, Optional

import rospy


def any_type_as(expected: Any) -> type:
    """Return a class with which a topic of any type can be subscribed to.

    :param expected: message class for the registration
    """
    return type("Any" + expected.__name__, (rospy.AnyMsg,), {"_type": expected._type})


def decoder(expected: Any, advice: str) -> Callable[[Any], Optional[Any]]:
    """Return a function that decodes received messages.

    It returns None for a message of another type, and warns once for each such publisher.

    :param expected: message class
    :param advice: remedy for another type
    """
    warned = set()

    def decode(raw: Any) -> Optional[Any]:
        header = raw._connection_header
        if header["type"] == expected._type:
            return expected().deserialize(raw._buff)
        sender = header["callerid"]
        if sender not in warned:
            warned.add(sender)
            rospy.logwarn(
                "%s: ignoring the messages of %s: they are %s, not %s; %s",
                header["topic"],
                sender,
                header["type"],
                expected._type,
                advice,
            )
        return None

    return decode
