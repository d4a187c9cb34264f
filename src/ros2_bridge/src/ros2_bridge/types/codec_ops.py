# Pure: knows no ROS.
"""Operations that convert parts of a message between ROS 1's serialization and CDR.

An operation knows only its read position and the output so far. ``down`` converts to CDR, ``up`` to
ROS 1; :mod:`ros2_bridge.types.codec` joins them into codecs.
"""

import struct
from typing import Any, Callable, List, Tuple, Union

_LENGTH = struct.Struct("<I")
_LETTERS = {2: "H", 4: "I", 8: "Q"}
#: Padding before a length, and after it before numbers.
_PADDING = tuple(bytes(size) for size in range(5))
#: Most elements of an array whose elements are empty in ROS 1.
_MOST_EMPTY = 1_000_000

#: Reads the source at an offset, appends to the output, returns the offset behind the bytes read.
Instruction = Callable[[Any, int, bytearray], int]


class ConversionError(ValueError):
    """Bytes that are not a message of the type."""


class Number:
    """Consecutive numbers of the same size.

    :param packed, padded: their ``struct`` formats in ROS 1 and in ROS 2
    :param size: bytes of one number, its alignment in ROS 2; 1 without alignment
    :param bytes1, bytes2: bytes of all numbers in ROS 1 and in ROS 2
    """

    def __init__(self, packed: str, padded: str, size: int, bytes1: int, bytes2: int) -> None:
        self.packed, self.padded, self.size = packed, padded, size
        self.bytes1, self.bytes2 = bytes1, bytes2


# struct skips pad bytes when it reads, and writes them as zeros.
SEQ = Number("4x", "", 1, 4, 0)
EMPTY = Number("", "x", 1, 0, 1)
#: A time: its seconds are unsigned in ROS 1, and signed in ROS 2.
TIME = Number("II", "iI", 4, 8, 8)
_NO_TIME = "a time before 1970 or after 2038-01-19: only one of ROS 1 and ROS 2 can have it"


def number(size: int, count: int) -> Number:
    # Single bytes are handled as one string, which is fast for any number of them.
    note = f"{count}s" if size == 1 else f"{count}{_LETTERS[size]}"
    return Number(note, note, size, size * count, size * count)


#: Part of a message: numbers, or two operations (to CDR, to ROS 1) for variable sizes.
Piece = Union[Number, Tuple[Instruction, Instruction]]


def _run(numbers: List[Number]) -> Tuple[Instruction, Instruction]:
    """Compile consecutive numbers: their position determines the padding."""
    packed = struct.Struct("<" + "".join(number.packed for number in numbers))
    variants = []
    for start in range(8):
        notes, at = ["<"], start
        for number in numbers:
            gap = -at % number.size
            notes.append("x" * gap + number.padded)
            at += gap + number.bytes2
        variants.append(struct.Struct("".join(notes)))

    def down(source: Any, at: int, out: bytearray) -> int:
        values = packed.unpack_from(source, at)
        try:
            out += variants[len(out) & 7].pack(*values)
        except struct.error:  # only times have a limited range
            raise ConversionError(_NO_TIME) from None
        return at + packed.size

    def up(source: Any, at: int, out: bytearray) -> int:
        padded = variants[at & 7]
        values = padded.unpack_from(source, at)
        try:
            out += packed.pack(*values)
        except struct.error:
            raise ConversionError(_NO_TIME) from None
        return at + padded.size

    return down, up


def _count_down(source: Any, at: int, out: bytearray) -> int:
    out += _PADDING[-len(out) & 3] + source[at : at + 4]
    return int(_LENGTH.unpack_from(source, at)[0])


def _end(source: Any, at: int, size: int) -> int:
    """Return the end of some bytes, which must be within the source."""
    end = at + size
    if end > len(source):
        raise ConversionError(f"{size} bytes announced, {len(source) - at} left")
    return end


def text_down(source: Any, at: int, out: bytearray) -> int:
    (size,) = _LENGTH.unpack_from(source, at)
    end = _end(source, at + 4, size)
    out += _PADDING[-len(out) & 3] + _LENGTH.pack(size + 1)
    out += source[at + 4 : end]
    out.append(0)
    return end


def text_up(source: Any, at: int, out: bytearray) -> int:
    at += -at & 3
    (size,) = _LENGTH.unpack_from(source, at)
    end = _end(source, at + 4, size)
    text = source[at + 4 : end - 1]  # without the zero, if there is one
    out += _LENGTH.pack(len(text))
    out += text
    return end


def block(size: int, numbers: int) -> Tuple[Instruction, Instruction]:
    """Compile an array of numbers, or of messages that contain numbers of one size only.

    :param size: of a number [bytes]
    :param numbers: per element
    """

    def down(source: Any, at: int, out: bytearray) -> int:
        count = _count_down(source, at, out)
        end = _end(source, at + 4, count * numbers * size)
        if count:
            out += _PADDING[-len(out) % size]
            out += source[at + 4 : end]
        return end

    def up(source: Any, at: int, out: bytearray) -> int:
        at += -at & 3
        (count,) = _LENGTH.unpack_from(source, at)
        out += source[at : at + 4]
        at += 4
        if count:
            at += -at % size
        end = _end(source, at, count * numbers * size)
        out += source[at:end]
        return end

    return down, up


def array(element: Tuple[Instruction, Instruction], least: int) -> Tuple[Instruction, Instruction]:
    """Compile an array whose elements are converted one by one.

    :param least: minimum size of an element in ROS 1 [bytes]
    """
    element_down, element_up = element

    def check(count: int, left: int, least: int) -> None:
        if count * least > left or (not least and count > _MOST_EMPTY):
            raise ConversionError(f"{count} elements announced, {left} bytes left")

    def down(source: Any, at: int, out: bytearray) -> int:
        count = _count_down(source, at, out)
        at += 4
        check(count, len(source) - at, least)
        for _ in range(count):
            at = element_down(source, at, out)
        return at

    def up(source: Any, at: int, out: bytearray) -> int:
        at += -at & 3
        (count,) = _LENGTH.unpack_from(source, at)
        out += source[at : at + 4]
        at += 4
        check(count, len(source) - at, 1)
        for _ in range(count):
            at = element_up(source, at, out)
        return at

    return down, up


def repeated(
    element: Tuple[Instruction, Instruction], times: int
) -> Tuple[Instruction, Instruction]:
    def repeat(instruction: Instruction) -> Instruction:
        def run(source: Any, at: int, out: bytearray) -> int:
            for _ in range(times):
                at = instruction(source, at, out)
            return at

        return run

    return repeat(element[0]), repeat(element[1])


def chain(pieces: List[Piece]) -> Tuple[Instruction, Instruction]:
    """Compile consecutive parts."""
    pairs: List[Tuple[Instruction, Instruction]] = []
    numbers: List[Number] = []
    for piece in pieces:
        if isinstance(piece, Number):
            numbers.append(piece)
            continue
        if numbers:
            pairs.append(_run(numbers))
            numbers = []
        pairs.append(piece)
    if numbers:
        pairs.append(_run(numbers))
    if len(pairs) == 1:
        return pairs[0]

    def follow(instructions: List[Instruction]) -> Instruction:
        def run(source: Any, at: int, out: bytearray) -> int:
            for instruction in instructions:
                at = instruction(source, at, out)
            return at

        return run

    return follow([down for down, _ in pairs]), follow([up for _, up in pairs])
