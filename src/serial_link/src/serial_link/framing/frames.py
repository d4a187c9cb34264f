"""Frame format of rosserial since ROS Hydro.

See http://wiki.ros.org/rosserial/Overview/Protocol and ros-drivers/rosserial: 0xff, the version
0xfe, the length of the payload (16 bits), its checksum, the topic id (16 bits), the payload, the
checksum of id and payload. Numbers are little-endian. A checksum makes the sum of its bytes 255,
modulo 256.
"""

import struct
from typing import NamedTuple

SYNC, VERSION, OLD_VERSION = 0xFF, 0xFE, 0xFF
#: First bytes of a frame.
START = bytes((SYNC, VERSION))
#: Sizes: up to the topic id, up to the payload, and of a frame without payload [bytes].
HEADER, BEFORE_PAYLOAD, OVERHEAD = 5, 7, 8
#: Longest payload that the length field can represent [bytes].
LONGEST = 0x7FFF

_LENGTH, _ID = struct.Struct("<H"), struct.Struct("<H")
#: Start, length, checksum of the length, and topic id.
_BEFORE_PAYLOAD = struct.Struct("<2sHBH")
#: Size of id and length in the old protocol [bytes].
_OLD_HEADER = 4


class Frame(NamedTuple):
    """Content of a frame.

    :param topic_id: its topic id
    :param payload: a serialized message
    """

    topic_id: int
    payload: bytes


def encode(topic_id: int, payload: bytes) -> bytes:
    """Return an encoded frame.

    :param topic_id: 16 bits
    :param payload: a serialized message
    :raises ValueError: if the payload is too long for a frame
    """
    length = len(payload)
    if length > LONGEST:
        raise ValueError(f"a payload of {length} bytes: at most {LONGEST} fit into a frame")
    length_sum = 255 - sum(divmod(length, 256)) % 256
    body_sum = 255 - (sum(divmod(topic_id, 256)) + sum(payload)) % 256
    head = _BEFORE_PAYLOAD.pack(START, length, length_sum, topic_id)
    return b"%b%b%c" % (head, payload, body_sum)


#: Topic request of the protocol before ROS Hydro, seven bytes. A newer board takes the last one,
#: 0xff, for the beginning of a frame; the eighth byte ends that frame.
OLD_REQUEST = b"\xff\xff\x00\x00\x00\x00\xff\x00"
#: Start of a frame of a version that no board supports. A board that is waiting for the topic
#: request answers it with a time request; a configured board does not answer.
PROBE = bytes((SYNC, OLD_VERSION))


def count_old_frames(data: bytes, longest: int = 512) -> int:
    """Count frames of the protocol before ROS Hydro: version 0xff, no checksum of the length.

    :param data: bytes from a board
    :param longest: longest payload of a valid frame [bytes]
    """
    count, start = 0, data.find(PROBE)
    while start >= 0:
        end = _end_of_old_frame(data, start + len(PROBE), longest)
        count += bool(end)
        start = data.find(PROBE, end or start + 1)
    return count


def _end_of_old_frame(data: bytes, body: int, longest: int) -> int:
    """Return the end of an old-protocol frame, given the position of its id; 0 if malformed."""
    if body + _OLD_HEADER > len(data):
        return 0
    size = _LENGTH.unpack_from(data, body + _ID.size)[0]
    end = body + _OLD_HEADER + size + 1
    is_good = size <= longest and end <= len(data) and sum(data[body:end]) % 256 == 255
    return end if is_good else 0
