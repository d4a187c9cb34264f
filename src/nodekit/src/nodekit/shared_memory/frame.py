"""Frame sent on a TCPROS connection to announce a message that is in shared memory.

TCPROS messages begin with their length; an announcement begins with an impossible length. A message
with one large array of bytes is announced with the array's position: the rest is small, and the
array is read, or viewed, in place.
"""

import struct
from typing import NamedTuple

#: In place of the length of a message [4 bytes].
MARK = 0xFFFF_FFFF
_FRAME = struct.Struct("<IIQQQIQ")
#: Length of an announcement [bytes].
SIZE = _FRAME.size
#: Number of the field in a message without one large array.
NO_FIELD = 0xFFFF_FFFF


class Frame(NamedTuple):
    """Announcement of one message."""

    #: number of the segment
    segment: int
    #: length of the serialized message, from the segment's beginning [bytes]
    size: int
    #: begin and end of the array in it [bytes]
    start: int
    stop: int
    #: number of the array's field in the message, or :data:`NO_FIELD`
    field: int
    #: messages to this subscriber that were lost so far
    lost: int

    def pack(self) -> bytes:
        """Return the announcement."""
        return _FRAME.pack(MARK, *self)


def unpack_from(data: bytes, position: int) -> Frame:
    """Return an announcement.

    :param data: received data
    :param position: offset of the announcement [bytes]
    :raises ValueError: if the array is not within the message
    """
    frame = Frame._make(_FRAME.unpack_from(data, position)[1:])
    if not 0 <= frame.start <= frame.stop <= frame.size:
        raise ValueError(f"malformed announcement: {frame}")
    return frame
