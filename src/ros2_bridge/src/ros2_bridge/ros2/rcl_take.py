"""Taker of serialized ROS 2 messages with publisher ids (GIDs), which rclpy of Jazzy lacks.

The structures are from ``rmw/types.h`` and ``rcutils/types/uint8_array.h``.
"""

import ctypes
from typing import Any, Optional

from ros2_bridge.ros2.received_message import ReceivedMessage

#: Return codes of rcl: a message was taken; no message was available.
_TAKEN, _NONE = 0, 401
#: Sequence number of an unnumbered message.
_UNNUMBERED = 2**64 - 1
# PyDLL holds the GIL, as rclpy does: none of these calls blocks.
_rcl, _rcutils = ctypes.PyDLL("librcl.so"), ctypes.PyDLL("librcutils.so")


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
    """Taker of serialized messages, for one thread.

    Its buffer grows to the largest message, and is kept until the process ends.
    """

    def __init__(self) -> None:
        self._buffer = _Buffer(allocator=_rcutils.rcutils_get_default_allocator())
        self._info = _Info()
        self._given = ctypes.byref(self._buffer), ctypes.byref(self._info)

    def take(self, handle: Any) -> Optional[ReceivedMessage]:
        """Take a message; None if the queue is empty.

        :param handle: rclpy's subscription, held by the caller so that it is not destroyed
        :raises RuntimeError: if ROS 2 fails
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
