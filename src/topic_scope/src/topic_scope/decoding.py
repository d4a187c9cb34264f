"""Take numbers out of serialized messages, without making objects of them.

A scope reads thousands of messages a second and wants one number of each. Messages of a fixed size
are read in bulk; of others, what stands before the number is skipped. The format is described at
http://wiki.ros.org/roscpp/Overview/MessagesSerializationAndAdaptingTypes (little-endian; a string
and an array of undeclared length begin with a count of 32 bits).
"""

import struct
from typing import Callable, List, Sequence, Union

import numpy

from topic_scope.definitions import Array, Layout, Record, Scalar
from topic_scope.fields import FieldError, Lengths, Path, leaf_at, to_text

#: How to get on: a number of bytes, or a function from data and offset to the next offset.
Step = Union[int, Callable[[bytes, int], int]]

_COUNT = struct.Struct("<I")


class _TooShort(Exception):
    """An array ends before the element."""


class Decoder:
    """Reads one number out of messages of one layout.

    :param layout: layout of the messages
    :param path: where the number stands
    :raises FieldError: if no number stands there
    """

    def __init__(self, layout: Record, path: Path) -> None:
        steps, leaf = _steps_to(layout, path)
        if not isinstance(leaf, Scalar):
            raise FieldError("what stands there is no number")
        self._steps = steps
        self._size = layout.size
        self._is_time = leaf.datatype in ("time", "duration")
        self._struct = struct.Struct("<" + leaf.format)
        if layout.size is not None:
            self._type = numpy.dtype(
                {
                    "names": ["value"],
                    "formats": [(_numpy_format(leaf), (2,) if self._is_time else ())],
                    "offsets": [sum(step for step in steps if isinstance(step, int))],
                    "itemsize": layout.size,
                }
            )

    def decode(self, messages: Sequence[bytes]) -> numpy.ndarray:
        """Return the number in each message, NaN where an array is too short for it.

        :param messages: serialized messages, without the length that goes before each on the wire
        """
        if self._size is not None and all(len(data) == self._size for data in messages):
            values = numpy.frombuffer(b"".join(messages), self._type)["value"]
            if self._is_time:
                return values[:, 0] + values[:, 1] * 1e-9
            return values.astype(numpy.float64)
        return numpy.array([self._decode_one(data) for data in messages], numpy.float64)

    def _decode_one(self, data: bytes) -> float:
        try:
            values = self._struct.unpack_from(data, _follow(self._steps, data))
        except (_TooShort, struct.error):  # the latter: the message is cut off
            return float("nan")
        return values[0] + values[1] * 1e-9 if self._is_time else float(values[0])


def lengths_in(layout: Record, data: bytes) -> Lengths:
    """Return the function that tells how long the arrays of a serialized message are.

    :param layout: its layout
    :param data: the message
    """

    def length(path: Path) -> int:
        try:
            return int(_COUNT.unpack_from(data, _follow(_steps_to(layout, path)[0], data))[0])
        except (_TooShort, struct.error):
            return 0

    return length


def check_length(layout: Record, path: Path, lengths: Lengths) -> None:
    """Check that the arrays on the way to a place are long enough.

    :param layout: layout of the messages
    :param path: the place
    :param lengths: tells how many elements an array has whose length is not declared
    :raises FieldError: if one is too short
    """
    for position, part in enumerate(path):
        node = leaf_at(layout, path[:position])
        if isinstance(part, int) and isinstance(node, Array) and node.length is None:
            if part >= lengths(path[:position]):
                count = lengths(path[:position])
                raise FieldError(f"{to_text(path[:position])} has {count} elements now")


def _follow(steps: Sequence[Step], data: bytes) -> int:
    offset = 0
    for step in steps:
        offset = offset + step if isinstance(step, int) else step(data, offset)
    return offset


def _steps_to(layout: Layout, path: Path) -> "tuple[List[Step], Layout]":
    """Return the steps from the start of a message to a place in it, and what is there."""
    steps: List[Step] = []
    node = layout
    for part in path:
        if isinstance(part, str) and isinstance(node, Record):
            names = [name for name, _ in node.fields]
            if part not in names:
                raise FieldError(f"there is no {part} in {node.datatype}")
            position = names.index(part)
            for _, before in node.fields[:position]:
                steps += _skip(before)
            node = node.fields[position][1]
        elif isinstance(part, int) and isinstance(node, Array):
            steps.append(_step_to_element(node, part))
            node = node.element
        else:
            raise FieldError(f"{part} is not in {node.datatype}")
    return _merged(steps), node


def _skip(layout: Layout) -> List[Step]:
    """Return the steps over a part of a message."""
    if layout.size is not None:
        return [layout.size]
    if isinstance(layout, Record):
        return _merged([step for _, field in layout.fields for step in _skip(field)])
    if isinstance(layout, Array):
        return [_step_over_array(layout)]
    return [lambda data, offset: offset + 4 + _COUNT.unpack_from(data, offset)[0]]


def _step_over_array(array: Array) -> Step:
    over_elements = _step_over_elements(array.element)

    def step(data: bytes, offset: int) -> int:
        if array.length is not None:
            return over_elements(data, offset, array.length)
        return over_elements(data, offset + 4, _COUNT.unpack_from(data, offset)[0])

    return step


def _step_to_element(array: Array, index: int) -> Step:
    size = array.element.size
    if array.length is not None and index >= array.length:
        raise FieldError(f"the array has {array.length} elements only")
    if array.length is not None and size is not None:
        return int(index * size)
    over_elements = _step_over_elements(array.element)

    def step(data: bytes, offset: int) -> int:
        if array.length is None:
            if index >= _COUNT.unpack_from(data, offset)[0]:
                raise _TooShort
            offset += 4
        return over_elements(data, offset, index)

    return step


def _step_over_elements(element: Layout) -> Callable[[bytes, int, int], int]:
    size = element.size
    if size is not None:
        fixed = size
        return lambda data, offset, count: offset + count * fixed
    steps = _skip(element)

    def step(data: bytes, offset: int, count: int) -> int:
        for _ in range(count):  # ends with struct.error at the end of the data
            for one in steps:
                offset = offset + one if isinstance(one, int) else one(data, offset)
        return offset

    return step


def _merged(steps: Sequence[Step]) -> List[Step]:
    """Return the same steps, with those of a known length put together."""
    merged: List[Step] = []
    for step in steps:
        if isinstance(step, int) and merged and isinstance(merged[-1], int):
            merged[-1] += step
        else:
            merged.append(step)
    return merged


def _numpy_format(leaf: Scalar) -> str:
    return "<" + leaf.format[0] if leaf.datatype != "bool" else "?"
