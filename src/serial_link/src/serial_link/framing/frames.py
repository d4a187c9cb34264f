"""Frame format of rosserial since ROS Hydro.

The format is that of http://wiki.ros.org/rosserial/Overview/Protocol, read against
ros-drivers/rosserial: 0xff, the version 0xfe, the length of the payload as 16 bits, its checksum,
the topic's id as 16 bits, the payload, the checksum of id and payload. Numbers are little-endian. A
checksum is what makes the sum of the bytes 255, modulo 256.
"""

import struct
from typing import NamedTuple

SYNC, VERSION, OLD_VERSION = 0xFF, 0xFE, 0xFF
#: How a frame begins.
START = bytes((SYNC, VERSION))
#: Bytes before the topic's id, before the payload, and of a frame without a payload.
HEADER, BEFORE_PAYLOAD, OVERHEAD = 5, 7, 8
#: The longest payload that the length can tell of [bytes].
LONGEST = 0x7FFF

_LENGTH, _ID = struct.Struct("<H"), struct.Struct("<H")
#: Of the old protocol: id and length [bytes].
_OLD_HEADER = 4


class Frame(NamedTuple):
    """Content of a frame.

    :param topic_id: what it is about
    :param payload: a serialised message
    """

    topic_id: int
    payload: bytes


def checksum(data: bytes) -> int:
    """Return the byte that makes the sum of some bytes 255, modulo 256.

    :param data: the bytes
    """
    return 255 - sum(data) % 256


def encode(topic_id: int, payload: bytes) -> bytes:
    """Return a frame as it goes on the wire.

    :param topic_id: what it is about, of 16 bits
    :param payload: a serialised message
    :raises ValueError: if the payload is longer than a frame can tell
    """
    if len(payload) > LONGEST:
        raise ValueError(f"a payload of {len(payload)} bytes: at most {LONGEST} fit into a frame")
    length = _LENGTH.pack(len(payload))
    body = _ID.pack(topic_id) + payload
    return b"".join((START, length, bytes((checksum(length),)), body, bytes((checksum(body),))))


#: Seven bytes ask a board of before ROS Hydro for its topics. The last one ends what a newer board
#: makes of them: it takes the 0xff before it for the beginning of a frame.
OLD_REQUEST = b"\xff\xff\x00\x00\x00\x00\xff\x00"
#: A frame of a version that no board speaks. One that is waiting to be asked for its topics answers
#: with a request for the time; one that was asked already says nothing.
PROBE = bytes((SYNC, OLD_VERSION))


def count_old_frames(data: bytes, longest: int = 512) -> int:
    """Count frames of the protocol of before ROS Hydro: version 0xff, and no checksum of a length.

    :param data: what a board has sent
    :param longest: longest payload that counts as one [bytes]
    """
    count, start = 0, data.find(PROBE)
    while start >= 0:
        end = _end_of_old_frame(data, start + len(PROBE), longest)
        count += bool(end)
        start = data.find(PROBE, end or start + 1)
    return count


def _end_of_old_frame(data: bytes, body: int, longest: int) -> int:
    """Return where a frame of the old protocol ends, given where its id begins; 0 if malformed."""
    if body + _OLD_HEADER > len(data):
        return 0
    size = _LENGTH.unpack_from(data, body + _ID.size)[0]
    end = body + _OLD_HEADER + size + 1
    is_good = size <= longest and end <= len(data) and sum(data[body:end]) % 256 == 255
    return end if is_good else 0
