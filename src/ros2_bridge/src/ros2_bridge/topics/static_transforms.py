# Pure: knows no ROS.
"""Static transforms of a ROS 1 node, joined into one message.

A roscpp node latches a message for each of its publishers of a topic: nodelets of one manager, or
``rosbag play``, which has a publisher for each recorded node. All arrive on one connection, without
a sign of which replaces which. A ROS 2 publisher keeps its latest message, so a late subscriber
would miss the other transforms. A frame has only one static transform; a later one replaces it.
"""

import struct
from typing import Dict, Iterator, Tuple

#: ROS 1 type of the messages.
JOINED_TYPE = "tf2_msgs/TFMessage"
_LENGTH = struct.Struct("<I")
#: Size of ``seq`` and ``stamp`` before the name of the frame, and of the transform [bytes].
_HEAD, _TRANSFORM = 12, 56


class StaticTransforms:
    """Latest static transform of each child frame, as received on one connection."""

    def __init__(self) -> None:
        self._by_child: Dict[bytes, bytes] = {}

    def join(self, data: bytes) -> bytes:
        """Add the transforms of a message; return a message with all transforms so far.

        :param data: valid message in ROS 1's format
        """
        self._by_child.update(_transforms(data))
        return _LENGTH.pack(len(self._by_child)) + b"".join(self._by_child.values())


def _transforms(data: bytes) -> Iterator[Tuple[bytes, bytes]]:
    """Yield each child frame and its transform, both serialized."""
    at = _LENGTH.size
    for _ in range(*_LENGTH.unpack_from(data)):
        start = at
        child = _end_of_text(data, start + _HEAD)
        end = _end_of_text(data, child)
        at = end + _TRANSFORM
        yield data[child:end], data[start:at]


def _end_of_text(data: bytes, at: int) -> int:
    (size,) = _LENGTH.unpack_from(data, at)
    return at + _LENGTH.size + int(size)
