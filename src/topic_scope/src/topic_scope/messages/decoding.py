# Pure: knows no ROS.
"""Decoder of single numbers in serialized messages, without deserialising them.

A scope reads thousands of messages per second, and needs one number of each. Messages of fixed size
are decoded in bulk; in others, the data before the number are skipped. The format is described at
http://wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes (little-endian; a string
and an array of variable length start with a 32-bit count).
"""

import struct
from typing import Any, Callable, Iterator, List, Optional, Sequence, Tuple, Union

import numpy

from topic_scope.messages.message_layout import Array, Layout, MessageLayout, Scalar
from topic_scope.messages.fields import Key, FieldError, Path, label_of, names_of, to_path
from topic_scope.timing.nanoseconds import NO_TIME, NS, array_to_ns

#: Step over data: a number of bytes, or a function from data and offset to the next offset.
Advance = Union[int, Callable[[bytes, int], int]]

#: Length of an array, or of a text in bytes.
COUNT = struct.Struct("<I")


class ElementMissing(Exception):
    """Error of an array that ends before the element, or has no element of the name."""


class Decoder:
    """Decoder of one number of messages of one layout.

    :param layout: layout of the messages
    :param path: path of the number
    :raises FieldError: if the path is not a number

    :ivar is_time: whether the number is a time or a duration
    """

    def __init__(self, layout: MessageLayout, path: Path) -> None:
        steps, leaf = steps_to(layout, path)
        if not isinstance(leaf, Scalar):
            raise FieldError("the field is not a number")
        self._steps = steps
        # An element that is found by its value may be at any offset.
        self._size = layout.size if all(isinstance(step, int) for step in steps) else None
        self.is_time = leaf.datatype in ("time", "duration")
        self._is_wide = leaf.datatype in ("int64", "uint64")
        self._struct = struct.Struct("<" + leaf.format)
        if self._size is not None:
            self._type = numpy.dtype(
                {
                    "names": ["value"],
                    "formats": [(_numpy_format(leaf), (2,) if self.is_time else ())],
                    "offsets": [sum(step for step in steps if isinstance(step, int))],
                    "itemsize": self._size,
                }
            )

    def decode(self, messages: Sequence[bytes]) -> numpy.ndarray:
        """Return the number in each message; NaN if an array is too short.

        :param messages: serialized messages, without the length that precedes each on the wire
        """
        if self._size is not None and set(map(len, messages)) <= {self._size}:
            values = numpy.frombuffer(b"".join(messages), self._type)["value"]
            if self.is_time:
                return values[:, 0] + values[:, 1] * 1e-9
            return values.astype(numpy.float64)
        return numpy.array([self._decode_one(data) for data in messages], numpy.float64)

    def times(self, messages: Sequence[bytes]) -> numpy.ndarray:
        """Return the time in each message in whole nanoseconds.

        :returns: NO_TIME if it is missing, or not a valid time
        """
        if not self.is_time:
            return array_to_ns(self.decode(messages))
        if self._size is not None and set(map(len, messages)) <= {self._size}:
            values = numpy.frombuffer(b"".join(messages), self._type)["value"].astype(numpy.int64)
            return numpy.asarray(values[:, 0] * NS + values[:, 1])
        return numpy.array([self._time_of(data) for data in messages], numpy.int64)

    def rounding(self, values: numpy.ndarray) -> int:
        """Return the step that integers are rounded to: 1 if they are exact.

        :param values: as returned by :meth:`decode`
        """
        if not self._is_wide or not len(values):
            return 1
        return max(1, int(numpy.spacing(numpy.nanmax(numpy.abs(values), initial=0.0))))

    def has(self, message: bytes) -> bool:
        """Return whether a message has all array elements of the path."""
        try:
            follow(self._steps, message)
        except (ElementMissing, struct.error):
            return False
        return True

    def value(self, message: bytes) -> Any:
        """Return the exact value in a message.

        :returns: the number; nanoseconds for a time or a duration
        :raises ElementMissing: if an array element of its path is missing
        :raises struct.error: if the message is cut off
        """
        values = self._struct.unpack_from(message, follow(self._steps, message))
        return values[0] * NS + values[1] if self.is_time else values[0]

    def _time_of(self, data: bytes) -> int:
        try:
            return int(self.value(data))
        except (ElementMissing, struct.error):
            return NO_TIME

    def _decode_one(self, data: bytes) -> float:
        try:
            values = self._struct.unpack_from(data, follow(self._steps, data))
        except (ElementMissing, struct.error):  # struct.error: the message is cut off
            return float("nan")
        return values[0] + values[1] * 1e-9 if self.is_time else float(values[0])


def rounding_text(step: int) -> Optional[str]:
    """Describe the rounding of integers.

    :param step: as :meth:`Decoder.rounding` returns it
    :returns: None if they are exact
    """
    return f"whole numbers beyond 2**53: rounded to multiples of {step}" if step > 1 else None


def follow(steps: Sequence[Advance], data: bytes, offset: int = 0) -> int:
    """Return the offset after some steps in a message.

    :param offset: start of the steps
    :raises ElementMissing: if an array element of the path is missing
    :raises struct.error: if the message is cut off
    """
    for step in steps:
        offset = offset + step if isinstance(step, int) else step(data, offset)
    return offset


def steps_to(layout: MessageLayout, path: Path) -> Tuple[List[Advance], Layout]:
    """Return the steps from the start of a message to a path, and the layout there."""
    steps: List[Advance] = []
    node: Layout = layout
    for position, part in enumerate(path):
        if isinstance(part, Key) and part.field and isinstance(node, Array):
            steps.append(_step_to_labelled(node, part))
            node = node.element
        elif isinstance(part, Key) and isinstance(node, Array):
            names, _ = steps_to(layout, names_of(layout, path[:position]))
            steps.append(_step_to_named(node, part.encode(), names))
            node = node.element
        elif isinstance(part, str) and isinstance(node, MessageLayout):
            fields = [name for name, _ in node.fields]
            if part not in fields:
                raise FieldError(f"there is no {part} in {node.datatype}")
            place = fields.index(part)
            for _, before in node.fields[:place]:
                steps += _skip(before)
            node = node.fields[place][1]
        elif isinstance(part, int) and isinstance(node, Array):
            steps.append(_step_to_element(node, part))
            node = node.element
        else:
            raise FieldError(f"{part} is not in {node.datatype}")
    return _merged(steps), node


def _skip(layout: Layout) -> List[Advance]:
    """Return the steps over a part of a message."""
    if layout.size is not None:
        return [layout.size]
    if isinstance(layout, MessageLayout):
        return _merged([step for _, field in layout.fields for step in _skip(field)])
    if isinstance(layout, Array):
        return [_step_over_array(layout)]
    return [lambda data, offset: offset + 4 + COUNT.unpack_from(data, offset)[0]]


def _step_over_array(array: Array) -> Advance:
    over_elements = _step_over_elements(array.element)

    def step(data: bytes, offset: int) -> int:
        if array.length is not None:
            return over_elements(data, offset, array.length)
        return over_elements(data, offset + 4, COUNT.unpack_from(data, offset)[0])

    return step


def _step_to_element(array: Array, index: int) -> Advance:
    size = array.element.size
    if array.length is not None and index >= array.length:
        raise FieldError(f"the array has only {array.length} elements")
    if array.length is not None and size is not None:
        return int(index * size)
    over_elements = _step_over_elements(array.element)

    def step(data: bytes, offset: int) -> int:
        if array.length is None:
            if index >= COUNT.unpack_from(data, offset)[0]:
                raise ElementMissing
            offset += 4
        return over_elements(data, offset, index)

    return step


def _step_to_named(array: Array, name: bytes, names: Sequence[Advance]) -> Advance:
    """Return the step to the element at the index of its name in the array of names."""
    over_elements = _step_over_elements(array.element)

    def step(data: bytes, offset: int) -> int:
        count = array.length
        if count is None:
            count = COUNT.unpack_from(data, offset)[0]
            offset += 4
        for index, text in enumerate(texts(data, follow(names, data))):
            if text == name and index < count:
                return over_elements(data, offset, index)
        raise ElementMissing

    return step


def _step_to_labelled(array: Array, key: Key) -> Advance:
    """Return the step to the first element with a given value of a field."""
    read = labels(array, key.field)

    def step(data: bytes, offset: int) -> int:
        for label, place in read(data, offset):
            if label == key.value:
                return place
        raise ElementMissing

    return step


def labels(array: Array, field: str) -> Callable[[bytes, int], Iterator[Tuple[str, int]]]:
    """Return a reader of a field of each element of an array, with the offsets of the elements.

    :param array: layout of the array
    :param field: a text or an integer of its elements
    :returns: takes a message and the offset of the array; raises struct.error at the end of the
        data
    :raises FieldError: if the elements do not have such a field
    """
    leaf = label_of(array.element, field)
    steps, _ = steps_to(array.element, to_path(field))
    over_elements = _step_over_elements(array.element)
    number = struct.Struct("<" + leaf.format) if isinstance(leaf, Scalar) else None

    def read(data: bytes, offset: int) -> Iterator[Tuple[str, int]]:
        count = array.length
        if count is None:
            count, offset = COUNT.unpack_from(data, offset)[0], offset + COUNT.size
        for _ in range(count):
            place = follow(steps, data, offset)
            if number is not None:
                label = str(int(number.unpack_from(data, place)[0]))
            else:
                begin = place + COUNT.size
                end = begin + COUNT.unpack_from(data, place)[0]
                label = data[begin:end].decode("utf-8", "replace")
            yield label, offset
            offset = over_elements(data, offset, 1)

    return read


def texts(data: bytes, offset: int) -> Iterator[bytes]:
    """Return the texts of an array; raises struct.error at the end of the data."""
    count = COUNT.unpack_from(data, offset)[0]
    offset += 4
    for _ in range(count):
        begin = offset + 4
        offset = begin + COUNT.unpack_from(data, offset)[0]
        yield data[begin:offset]


def _step_over_elements(element: Layout) -> Callable[[bytes, int, int], int]:
    size = element.size
    if size is not None:
        fixed = size
        return lambda data, offset, count: offset + count * fixed
    steps = _skip(element)

    def step(data: bytes, offset: int, count: int) -> int:
        for _ in range(count):  # raises struct.error at the end of the data
            for one in steps:
                offset = offset + one if isinstance(one, int) else one(data, offset)
        return offset

    return step


def _merged(steps: Sequence[Advance]) -> List[Advance]:
    """Return the same steps, with steps of known length merged."""
    merged: List[Advance] = []
    for step in steps:
        if isinstance(step, int) and merged and isinstance(merged[-1], int):
            merged[-1] += step
        else:
            merged.append(step)
    return merged


def _numpy_format(leaf: Scalar) -> str:
    return "<" + leaf.format[0] if leaf.datatype != "bool" else "?"
