"""Patch of rospy's serialize_message: clears the send buffer if a message cannot be serialized."""

from typing import Any

import rospy.impl.tcpros_base
import rospy.msg
import rospy.topics

_USERS = (rospy.msg, rospy.topics, rospy.impl.tcpros_base)


def patch_serialization() -> None:
    """Clear the buffer if a message cannot be serialized.

    rospy leaves the fields before the invalid field in the buffer. They corrupt all later messages,
    and the client of a service gets them as a response.
    """
    serialise = rospy.msg.serialize_message

    def serialize_or_clear(buffer: Any, *arguments: Any) -> None:
        try:
            serialise(buffer, *arguments)
        except BaseException:
            buffer.seek(0)
            buffer.truncate(0)
            raise

    for module in _USERS:
        if getattr(module, "serialize_message", None) is serialise:
            setattr(module, "serialize_message", serialize_or_clear)
