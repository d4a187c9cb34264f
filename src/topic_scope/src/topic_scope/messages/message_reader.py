# Pure: knows no ROS.
"""Reader of whole messages by their layout, as dictionaries, lists and numeric arrays.

A plot needs single numbers, see :mod:`topic_scope.messages.decoding`; the robot view needs most of
a message. Types need not be installed here either.
"""

import struct
from typing import Any, Callable, Dict, List, Tuple

import numpy

from topic_scope.messages.message_layout import Array, Layout, MessageLayout, Scalar

#: From data and offset to the value there and the next offset.
Reader = Callable[[bytes, int], Tuple[Any, int]]

_COUNT = struct.Struct("<I")


class TruncatedMessage(ValueError):
    """Message that ends before its declared length."""


class MessageReader:
    """Reader of messages of one layout.

    :param layout: their layout
    """

    def __init__(self, layout: MessageLayout) -> None:
        self._read = _reader(layout)

    def read(self, data: bytes) -> Dict[str, Any]:
        """Return a message: numbers, strings, numeric arrays, and lists and dictionaries of them.

        :param data: the serialized message; times are converted to s
        :raises TruncatedMessage: if it is truncated
        """
        try:
            message: Dict[str, Any] = self._read(data, 0)[0]
        except (struct.error, ValueError) as error:
            raise TruncatedMessage(f"the message is cut off: {error}") from None
        return message


def _reader(layout: Layout) -> Reader:
    if isinstance(layout, Scalar):
        return _scalar(layout)
    if isinstance(layout, MessageLayout):
        return _record(layout)
    if isinstance(layout, Array):
        return _array(layout)
    return _text


def _scalar(layout: Scalar) -> Reader:
    form = struct.Struct("<" + layout.format)
    is_time = layout.datatype in ("time", "duration")

    def read(data: bytes, offset: int) -> Tuple[Any, int]:
        values = form.unpack_from(data, offset)
        return (values[0] + values[1] * 1e-9 if is_time else values[0]), offset + form.size

    return read


def _text(data: bytes, offset: int) -> Tuple[str, int]:
    start = offset + _COUNT.size
    end = start + _COUNT.unpack_from(data, offset)[0]
    if end > len(data):
        raise TruncatedMessage("a text ends beyond the message")
    return data[start:end].decode(errors="replace"), end


def _record(layout: MessageLayout) -> Reader:
    readers = [(name, _reader(field)) for name, field in layout.fields]

    def read(data: bytes, offset: int) -> Tuple[Dict[str, Any], int]:
        message = {}
        for name, reader in readers:
            message[name], offset = reader(data, offset)
        return message, offset

    return read


def _array(layout: Array) -> Reader:
    element, length = layout.element, layout.length
    elements = _numbers(element) if _is_plain(element) else _list(_reader(element))

    def read(data: bytes, offset: int) -> Tuple[Any, int]:
        count = length
        if count is None:
            count, offset = _COUNT.unpack_from(data, offset)[0], offset + _COUNT.size
        if count > len(data):  # the count of empty elements is otherwise unbounded
            raise TruncatedMessage("an array ends beyond the message")
        return elements(data, offset, count)

    return read


def _is_plain(element: Layout) -> bool:
    return isinstance(element, Scalar) and element.datatype not in ("time", "duration")


def _numbers(element: Any) -> Callable[[bytes, int, int], Tuple[Any, int]]:
    numbers = numpy.dtype("?" if element.datatype == "bool" else "<" + element.format)

    def read(data: bytes, offset: int, count: int) -> Tuple[numpy.ndarray, int]:
        end = offset + count * element.size
        if end > len(data):
            raise TruncatedMessage("an array ends beyond the message")
        return numpy.frombuffer(data, numbers, count, offset), end

    return read


def _list(reader: Reader) -> Callable[[bytes, int, int], Tuple[Any, int]]:
    def read(data: bytes, offset: int, count: int) -> Tuple[List[Any], int]:
        values = []
        for _ in range(count):
            value, offset = reader(data, offset)
            values.append(value)
        return values, offset

    return read
