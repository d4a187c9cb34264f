"""Goal ids: any text in ROS 1, 16 bytes in ROS 2."""

import uuid

#: What the ids of ROS 1's own goals are derived from, the same ones in each bridge.
_SPACE = uuid.UUID("5f4cf9ba-8d63-4f5e-9d35-0c51d9c4a1f7")
#: ROS 2's for no goal; ROS 1's is the empty text.
NO_GOAL = bytes(16)


def text_of(goal_id: bytes) -> str:
    """Return ROS 1's id of a goal of ROS 2, which is read back as the same 16 bytes."""
    return str(uuid.UUID(bytes=goal_id)) if goal_id != NO_GOAL else ""


def bytes_of(text: str) -> bytes:
    """Return ROS 2's id of a goal of ROS 1.

    From one that does not come from ROS 2 there is no way back, so that has to be kept.
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
