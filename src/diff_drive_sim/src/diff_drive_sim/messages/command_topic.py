"""A topic whose publishers may have the wrong type, and are told so.

ROS lets nobody with another type connect: not one message comes, and what the log says of it names
neither the topic nor a way out. So the topic is heard with any type, and what is not the expected
one is left out with a sentence. The master is told the expected type all the same.
"""

from typing import Any, Callable, Optional

import rospy


def heard_as(expected: Any) -> type:
    """Return a class as which a topic can be heard whatever its type.

    :param expected: message class of which the master is told
    """
    return type("Any" + expected.__name__, (rospy.AnyMsg,), {"_type": expected._type})


def decoder(expected: Any, advice: str) -> Callable[[Any], Optional[Any]]:
    """Return a function that decodes what is heard.

    It returns None for a message of another type, and warns once for each such publisher.

    :param expected: message class
    :param advice: what to do about another type
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
                "%s: %s sends %s, and %s is expected: its messages are left out; %s",
                header["topic"],
                sender,
                header["type"],
                expected._type,
                advice,
            )
        return None

    return decode
