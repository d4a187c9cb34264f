"""Conversion of goal ids: any string in ROS 1, 16 bytes in ROS 2."""

import uuid

#: Namespace of the UUIDs of ROS 1 goals, the same in every bridge.
_SPACE = uuid.UUID("5f4cf9ba-8d63-4f5e-9d35-0c51d9c4a1f7")
#: ROS 2's id for "no goal"; ROS 1 uses the empty string.
NO_GOAL = bytes(16)


def text_of(goal_id: bytes) -> str:
    """Return the ROS 1 id of a ROS 2 goal; :func:`bytes_of` inverts it."""
    return str(uuid.UUID(bytes=goal_id)) if goal_id != NO_GOAL else ""


def bytes_of(text: str) -> bytes:
    """Return the ROS 2 id of a ROS 1 goal.

    Unless the id comes from :func:`text_of`, this is a hash, so the caller has to keep the
    original.
    """
    if not text:
        return NO_GOAL
    try:
        found = uuid.UUID(text)
    except ValueError:
        found = None
    if found is None or str(found) != text or found.bytes == NO_GOAL:
        found = uuid.uuid5(_SPACE, text)
    return found.bytes
