"""Serialization of messages with one large array of bytes, such as an image, without a copy.

genpy's ``serialize`` copies each field several times, and its ``deserialize`` needs the whole
message in one object. Here they are given the message without the array, which is put in its place
in the serialized form.
"""

import copy
import functools
import os
import struct
from typing import Any, Callable, Optional, Tuple, cast

#: Arrays of at least this size are not copied [bytes].
LEAST_BYTES = 65_536

_LENGTH = struct.Struct("<I")
#: Placeholder of an array in a serialized message, to find its position.
_PLACEHOLDER = os.urandom(16)
_NO_ARRAY = _LENGTH.pack(0)


@functools.lru_cache(maxsize=None)
def byte_fields(data_class: Any) -> Tuple[int, ...]:
    """Return the numbers of a message class's fields that are arrays of bytes of any length.

    :param data_class: message class
    """
    types = getattr(data_class, "_slot_types", ())
    return tuple(n for n, name in enumerate(types) if name in ("uint8[]", "char[]"))


class SplitMessage:
    """Serialized message in three parts: the bytes before a large array, the array, the rest.

    :param head: with the lengths of the message and of the array
    :param array: the array: bytes, a bytearray or a view
    :param tail: the bytes after the array
    :param field: number of the array's field
    """

    __slots__ = ("head", "array", "tail", "field")

    def __init__(self, head: bytes, array: Any, tail: bytes, field: int) -> None:
        self.head, self.array, self.tail, self.field = head, array, tail, field

    def __len__(self) -> int:
        return len(self.head) + len(self.array) + len(self.tail)

    def joined(self) -> bytes:
        """Return the message in one part."""
        return b"".join((self.head, self.array, self.tail))

    def body(self) -> "SplitMessage":
        """Return the message without its length."""
        return SplitMessage(self.head[_LENGTH.size :], self.array, self.tail, self.field)

    def fill(self, message: Any) -> None:
        """Deserialize this message, without its length.

        :param message: the message to be filled; it shares the array if that is ``bytes``
        :raises genpy.DeserializationError: if the rest is malformed
        """
        fill(message, self.head, self.tail, self.field, bytes(self.array))


def split(message: Any, serialize: Callable[[Any], bytes]) -> Optional[SplitMessage]:
    """Serialize a message without copying its largest array of bytes.

    :param message: the message
    :param serialize: returns a serialized message with its length
    :returns: the message; None if it has no large array of bytes
    :raises genpy.SerializationError: as ``serialize``
    """
    data_class: Any = type(message)
    most, field = LEAST_BYTES - 1, -1
    for number in byte_fields(data_class):
        array = getattr(message, data_class.__slots__[number])
        is_bytes = type(array) in (bytes, bytearray) or _is_view(array) and array.c_contiguous
        if is_bytes and len(array) > most:
            most, field = len(array), number
    if field < 0:
        return None
    name = data_class.__slots__[field]
    small = copy.copy(message)
    setattr(small, name, _PLACEHOLDER)
    packet = serialize(without_views(small))
    if packet.count(_PLACEHOLDER) != 1:
        return None
    place = packet.find(_PLACEHOLDER)
    array, tail = getattr(message, name), packet[place + len(_PLACEHOLDER) :]
    before = packet[_LENGTH.size : place - _LENGTH.size] + _LENGTH.pack(len(array))
    return SplitMessage(
        _LENGTH.pack(len(before) + len(array) + len(tail)) + before, array, tail, field
    )


def _is_view(array: Any) -> bool:
    return isinstance(array, memoryview) and array.itemsize == array.ndim == 1


def with_views(message: Any) -> Any:
    """Return a message whose arrays of bytes are read-only views.

    :param message: the message, which is not changed
    :returns: the message itself, or a copy that shares its other fields
    """
    return _converted(
        message,
        lambda array: not isinstance(array, memoryview),
        lambda array: memoryview(array).toreadonly(),
    )


def without_views(message: Any) -> Any:
    """Return a message with ``bytes`` in place of views, which genpy does not serialize.

    :param message: the message, which is not changed
    :returns: the message itself, or a copy that shares its other fields
    """
    return _converted(message, _is_view, bytes)


def _converted(
    message: Any, has_to_be: Callable[[Any], bool], convert: Callable[[Any], Any]
) -> Any:
    result, data_class = message, cast(Any, type(message))
    for number in byte_fields(data_class):
        name = message.__slots__[number]
        array = getattr(message, name)
        if has_to_be(array):
            if result is message:
                result = copy.copy(message)
            setattr(result, name, convert(array))
    return result


def fill(message: Any, head: bytes, tail: bytes, field: int, array: Any) -> None:
    """Deserialize a message.

    :param message: the message to be filled
    :param head: the bytes before the array, with the array's length
    :param tail: the bytes after the array
    :param field: number of the array's field
    :param array: the array
    :raises genpy.DeserializationError: if the rest is malformed
    """
    data_class: Any = type(message)
    if field in byte_fields(data_class):
        message.deserialize(head[: -_LENGTH.size] + _NO_ARRAY + tail)
        setattr(message, message.__slots__[field], array)
    else:  # of any type
        message.deserialize(b"".join((head, array, tail)))
