"""Status list of a ROS 2 action server, parsed and written as bytes (CDR).

The list has all goals of the last 15 minutes, and is published at each change: an object for each
goal would take most of the bridge's CPU time. Imports neither ROS.
"""

import struct
from typing import Iterable, List, NamedTuple, Tuple

#: Little endian, no options.
_CDR = b"\0\1\0\0"
_COUNT = struct.Struct("<I")
#: A goal: its id, padding before its stamp, its stamp, its status.
_GOAL = struct.Struct("<16s3xiIb")
#: The first goal's stamp is aligned without this padding.
_AT, _BYTES = 16, 3
#: Largest second in ROS 2.
_LAST_S = 2**31 - 1


class ListedGoal(NamedTuple):
    """A goal of the list.

    :param uuid: its id in ROS 2
    :param stamp: its start time [ns]
    :param status: status number, possibly unknown
    """

    uuid: bytes
    stamp: int
    status: int


def write_list(goals: Iterable[ListedGoal]) -> bytes:
    """Return the message with these goals."""
    rows = [_GOAL.pack(uuid, *seconds_of(stamp), status) for uuid, stamp, status in goals]
    joined = b"".join(rows)
    return _CDR + _COUNT.pack(len(rows)) + joined[:_AT] + joined[_AT + _BYTES :]


def read_list(data: bytes) -> List[ListedGoal]:
    """Return the goals in a message.

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
        ListedGoal(uuid, seconds * 10**9 + rest, status)
        for uuid, seconds, rest, status in _GOAL.iter_unpack(rows)
    ]


def seconds_of(stamp: int) -> Tuple[int, int]:
    """Return a time [ns] as seconds and nanoseconds, within ROS 2's range (ROS 1's is larger)."""
    seconds, rest = divmod(stamp, 10**9)
    return min(seconds, _LAST_S), rest
