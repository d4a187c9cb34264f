"""How rospy writes a message into the buffer that it sends."""

from typing import Any

import rospy.impl.tcpros_base
import rospy.msg
import rospy.topics

_USERS = (rospy.msg, rospy.topics, rospy.impl.tcpros_base)


def patch_serialization() -> None:
    """Leave nothing half-written of a message with a field that does not fit.

    rospy leaves in the buffer what came before that field. The next messages then follow it and
    reach nobody, and the client of a service gets it for an answer.
    """
    serialise = rospy.msg.serialize_message

    def serialise_or_clear(buffer: Any, *arguments: Any) -> None:
        try:
            serialise(buffer, *arguments)
        except BaseException:
            buffer.seek(0)
            buffer.truncate(0)
            raise

    for module in _USERS:
        if getattr(module, "serialize_message", None) is serialise:
            setattr(module, "serialize_message", serialise_or_clear)
