"""Take of messages with their senders, which Jazzy's rclpy does not return.

The structures are those of ``rmw/types.h`` and ``rcutils/types/uint8_array.h``.
"""

import ctypes
from typing import Any, NamedTuple, Optional

#: rcl's own: a message was taken, and no message waited.
_TAKEN, _NONE = 0, 401
#: The number of a message that has none.
_UNNUMBERED = 2**64 - 1
# Held meanwhile is Python's lock, as by rclpy: nothing in there waits.
_rcl, _rcutils = ctypes.PyDLL("librcl.so"), ctypes.PyDLL("librcutils.so")


class ReceivedMessage(NamedTuple):
    """A message from ROS 2.

    :param data: its bytes
    :param sender: 16 bytes that name the publisher
    :param number: which of that publisher's messages it is, None where it is not numbered
    """

    data: bytes
    sender: bytes
    number: Optional[int]


class _Allocator(ctypes.Structure):
    _fields_ = [
        (name, ctypes.c_void_p)
        for name in ("allocate", "deallocate", "reallocate", "zero_allocate", "state")
    ]


class _Buffer(ctypes.Structure):
    _fields_ = [
        ("buffer", ctypes.c_void_p),
        ("buffer_length", ctypes.c_size_t),
        ("buffer_capacity", ctypes.c_size_t),
        ("allocator", _Allocator),
    ]


class _Gid(ctypes.Structure):
    _fields_ = [("implementation_identifier", ctypes.c_char_p), ("data", ctypes.c_uint8 * 16)]


class _Info(ctypes.Structure):
    _fields_ = [
        ("source_timestamp", ctypes.c_int64),
        ("received_timestamp", ctypes.c_int64),
        ("publication_sequence_number", ctypes.c_uint64),
        ("reception_sequence_number", ctypes.c_uint64),
        ("publisher_gid", _Gid),
        ("from_intra_process", ctypes.c_bool),
    ]


_rcutils.rcutils_get_default_allocator.restype = _Allocator
_take = _rcl.rcl_take_serialized_message
_take.argtypes = [
    ctypes.c_void_p,
    ctypes.POINTER(_Buffer),
    ctypes.POINTER(_Info),
    ctypes.c_void_p,
]
_take.restype = ctypes.c_int


class MessageTaker:
    """Taker of serialized messages of subscriptions, for one thread.

    Its buffer has grown to the largest message that has come, and stays until the process ends.
    """

    def __init__(self) -> None:
        self._buffer = _Buffer(allocator=_rcutils.rcutils_get_default_allocator())
        self._info = _Info()
        self._given = ctypes.byref(self._buffer), ctypes.byref(self._info)

    def take(self, handle: Any) -> Optional[ReceivedMessage]:
        """Take a message; None if none waits.

        :param handle: of rclpy's subscription, held by the caller so that it is not destroyed
        :raises RuntimeError: if ROS 2 cannot
        """
        code = _take(handle.pointer, *self._given, None)
        if code == _NONE:
            return None
        if code != _TAKEN:
            _rcutils.rcutils_reset_error()
            raise RuntimeError(f"ROS 2 cannot take a message of {handle.get_topic_name()}: {code}")
        info, number = self._info, self._info.publication_sequence_number
        return ReceivedMessage(
            ctypes.string_at(self._buffer.buffer, self._buffer.buffer_length),
            bytes(info.publisher_gid.data),
            None if number == _UNNUMBERED else number,
        )
