"""The list of goals that an action server of ROS 2 publishes, as bytes (CDR).

It has all goals of the last 15 minutes, and is published at each change of one of them: an object
for each goal would take most of the bridge's time. Knows neither ROS.
"""

import struct
from typing import Iterable, List, NamedTuple, Tuple

#: Little endian, no options.
_CDR = b"\0\1\0\0"
_COUNT = struct.Struct("<I")
#: A goal: its id, the bytes that have its stamp at a multiple of four, its stamp, its status.
_GOAL = struct.Struct("<16s3xiIb")
#: The first one's stamp is there without these bytes.
_AT, _BYTES = 16, 3
#: The last second of ROS 2's time.
_LAST_S = 2**31 - 1


class Listed(NamedTuple):
    """A goal of the list.

    :param uuid: its id in ROS 2
    :param stamp: when it began [ns]
    :param status: number of its status, which may be an unknown one
    """

    uuid: bytes
    stamp: int
    status: int


def write_list(goals: Iterable[Listed]) -> bytes:
    """Return the message that has these goals."""
    rows = [_GOAL.pack(uuid, *seconds_of(stamp), status) for uuid, stamp, status in goals]
    joined = b"".join(rows)
    return _CDR + _COUNT.pack(len(rows)) + joined[:_AT] + joined[_AT + _BYTES :]


def read_list(data: bytes) -> List[Listed]:
    """Return the goals that a message has.

    :raises ValueError: if it is malformed
    """
    try:
        (count,) = _COUNT.unpack_from(data, len(_CDR))
    except struct.error as error:
        raise ValueError(str(error)) from None
    at = len(_CDR) + _COUNT.size
    end = at + max(0, count * _GOAL.size - _BYTES)
    if data[: len(_CDR)] != _CDR or end > len(data):
        raise ValueError(f"{count} goals announced in {len(data)} bytes")
    rows = data[at : at + _AT] + bytes(_BYTES) + data[at + _AT : end] if count else b""
    return [
        Listed(uuid, seconds * 10**9 + rest, status)
        for uuid, seconds, rest, status in _GOAL.iter_unpack(rows)
    ]


def seconds_of(stamp: int) -> Tuple[int, int]:
    """Return a time [ns], in seconds and the rest [ns], as ROS 2 has it: ROS 1's ends later."""
    seconds, rest = divmod(stamp, 10**9)
    return min(seconds, _LAST_S), rest
