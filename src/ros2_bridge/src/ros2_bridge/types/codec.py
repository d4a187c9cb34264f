# Pure: knows no ROS.
"""Codec between serialized ROS 1 messages and CDR, without message objects.

A definition is compiled once into operations; afterwards a codec is stateless, and so thread-safe.
Both formats are little-endian. CDR, as ROS 2 writes it, differs in five points: each number is
aligned to its size, counted from behind the first four bytes; a string ends with a zero, which is
counted; a Header has no ``seq``; the seconds of a time are signed; and an empty message has one
byte.
"""

import struct
from typing import Any, Dict, List, Tuple

from nodekit.message_definitions import SIZES, TIMES, Field, Fields
from ros2_bridge.types.field_mapping import FieldMapping
from ros2_bridge.types.codec_ops import (
    EMPTY,
    SEQ,
    TIME,
    ConversionError,
    Instruction,
    Number,
    Piece,
    array,
    block,
    chain,
    number,
    repeated,
    text_down,
    text_up,
)

#: CDR header: little-endian, no options.
_CDR = b"\0\1\0\0"
_LENGTH = struct.Struct("<I")
#: Exceptions that malformed bytes cause in an operation.
_FAILURES = (struct.error, ConversionError)


class _Compiler:
    def __init__(self, fields: Fields) -> None:
        self._fields = fields
        self._known: Dict[str, List[Piece]] = {}

    def message(self, datatype: str) -> List[Piece]:
        if datatype not in self._known:
            pieces = [piece for field in self._fields[datatype] for piece in self._field(field)]
            if datatype == "std_msgs/Header":
                pieces[0] = SEQ
            self._known[datatype] = pieces or [EMPTY]
        return self._known[datatype]

    def _field(self, field: Field) -> List[Piece]:
        element = self._element(field.base)
        if not field.is_array:
            return element
        if field.length is not None:
            return self._fixed_array(field.base, field.length, element)
        numbers = [piece for piece in element if isinstance(piece, Number)]
        sizes = {number.size for number in numbers}
        if len(numbers) < len(element) or len(sizes) != 1 or {EMPTY, TIME}.intersection(numbers):
            least = sum(piece.bytes1 if isinstance(piece, Number) else 4 for piece in element)
            return [array(chain(element), least)]
        (size,) = sizes
        return [block(size, sum(number.bytes1 for number in numbers) // size)]

    def _fixed_array(self, base: str, length: int, element: List[Piece]) -> List[Piece]:
        if base in SIZES:
            return [number(SIZES[base], length)]
        if all(isinstance(piece, Number) for piece in element) and length * len(element) < 1000:
            return element * length
        return [repeated(chain(element), length)]

    def _element(self, base: str) -> List[Piece]:
        if base in SIZES:
            return [number(SIZES[base], 1)]
        if base in TIMES:
            return [TIME if base == "time" else number(4, 2)]
        if base == "string":
            return [(text_down, text_up)]
        return self.message(base)


class Codec:
    """Converter of messages of one type.

    :param datatype: its name in ROS 1
    :param fields: its definition, from :func:`nodekit.message_definitions.parse`

    :ivar has_header: whether it begins with a Header, whose ``seq`` counts the messages of a topic
    """

    def __init__(self, datatype: str, fields: Fields) -> None:
        self._type = datatype
        self._down, self._up = chain(_Compiler(fields).message(datatype))
        self.has_header = begins_with_header(fields[datatype])

    def to_cdr(self, data: bytes) -> bytes:
        """Convert a ROS 1 message to CDR.

        :raises ConversionError: if it is not a message of this type
        """
        out = bytearray()
        end = self._convert(self._down, data, out)
        if end != len(data):
            raise ConversionError(f"{self._type}: {len(data) - end} bytes too many")
        return _CDR + out  # of type bytes, like its first operand

    def to_ros1(self, cdr: bytes, seq: int = 0) -> bytes:
        """Convert a CDR message to ROS 1.

        :param cdr: the message
        :param seq: for its Header, if it begins with one
        :raises ConversionError: if it is not a message of this type
        """
        if cdr[:2] != _CDR[:2]:
            raise ConversionError(
                f"{self._type}: {cdr[:4]!r} is not the start of a little-endian CDR"
            )
        out = bytearray()
        self._convert(self._up, memoryview(cdr)[4:], out)
        if self.has_header:
            _LENGTH.pack_into(out, 0, seq & 0xFFFFFFFF)
        return bytes(out)

    def _convert(self, instruction: Instruction, source: Any, out: bytearray) -> int:
        try:
            return instruction(source, 0, out)
        except _FAILURES as error:
            raise ConversionError(f"{self._type}: {error}") from None


class MappedCodec:
    """Converter of messages between types with other fields; see :class:`Codec`.

    :param codec: of the ROS 2 type in ROS 1's terms
    :param mapping: converter between the ROS 1 type and the ROS 2 type in ROS 1's terms
    :param fields: definition of the ROS 1 type
    :param datatype: its name
    """

    def __init__(self, codec: Codec, mapping: FieldMapping, fields: Fields, datatype: str) -> None:
        self._codec, self._mapping = codec, mapping
        self.has_header = begins_with_header(fields[datatype])

    def to_cdr(self, data: bytes) -> bytes:
        """Convert a ROS 1 message to CDR.

        :raises ConversionError: if it is not a message of this type
        """
        return self._codec.to_cdr(self._mapping.to_second(data))

    def to_ros1(self, cdr: bytes, seq: int = 0) -> bytes:
        """Convert a CDR message to ROS 1.

        :param cdr: the message
        :param seq: for its Header, if it begins with one
        :raises ConversionError: if it is not a message of this type
        """
        out = bytearray(self._mapping.to_first(self._codec.to_ros1(cdr)))
        if self.has_header:
            _LENGTH.pack_into(out, 0, seq & 0xFFFFFFFF)
        return bytes(out)


def begins_with_header(fields: Tuple[Field, ...]) -> bool:
    """Return whether the first field of a message is its Header."""
    return [(f.base, f.is_array) for f in fields[:1]] == [("std_msgs/Header", False)]
