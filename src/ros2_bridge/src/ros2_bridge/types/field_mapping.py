# Pure: knows no ROS.
"""Conversion between a ROS 1 type and a ROS 2 type by mapping rules, both serialized as in ROS 1.

The second type is a ROS 2 type in ROS 1's terms. Fields correspond by name, unless a rule gives a
field another counterpart, or none. A converter is compiled once; it slices messages into their
fields and joins them in the other type's order, so it copies numbers and text as they are.
"""

import struct
from typing import Callable, Dict, List, NamedTuple, Optional, Tuple

from nodekit.message_definitions import SIZES, TIMES, Field, Fields
from ros2_bridge.types.codec_ops import ConversionError
from ros2_bridge.types.type_pair import Leaf, RulesByType, TypePair, is_within, leaves

#: Returns the position behind a field that begins at a position.
_Skip = Callable[[bytes, int], int]
#: Converts a serialized field.
_Convert = Callable[[bytes], bytes]
_COUNT = struct.Struct("<I")
#: Types with two names; others, such as int32 and uint32, would change values.
_ALIASES = {"byte": "int8", "char": "uint8"}


class MappingError(ValueError):
    """Error of two types whose fields do not correspond; the text has all reasons."""


class _Part(NamedTuple):
    """Field of the converted message: a converted field of the original, or a default.

    :param source: index of the original's field; None for the default
    """

    source: Optional[int]
    default: bytes
    convert: Optional[_Convert]


class _Direction:
    """Compiled conversion in one direction.

    :param skips: functions that find the end of each field of the original
    :param parts: fields of the converted message
    """

    def __init__(self, skips: List[_Skip], parts: List[_Part]) -> None:
        self._skips, self._parts = skips, parts

    @property
    def is_copy(self) -> bool:
        """Whether the fields are copied in their order."""
        copies = [_Part(index, b"", None) for index in range(len(self._skips))]
        return self._parts == copies

    def skip(self, data: bytes, at: int) -> int:
        """Return the position behind a message."""
        for skip in self._skips:
            at = skip(data, at)
        return at

    def convert(self, data: bytes) -> bytes:
        """Convert a message.

        :raises ConversionError: if it has another length than its fields
        """
        ends, at = [0], 0
        try:
            for skip in self._skips:
                at = skip(data, at)
                ends.append(at)
        except struct.error:
            at = -1
        if at != len(data):
            raise ConversionError(f"{len(data)} bytes are not a message of this type")
        pieces = []
        for source, default, convert in self._parts:
            piece = default if source is None else data[ends[source] : ends[source + 1]]
            pieces.append(piece if convert is None or source is None else convert(piece))
        return b"".join(pieces)


class FieldMapping:
    """Converter between a ROS 1 type and a ROS 2 type in ROS 1's terms, in both directions.

    :param first: the ROS 1 type
    :param fields1: its definition, from :func:`nodekit.message_definitions.parse`
    :param second: the ROS 2 type
    :param fields2: its definition, with ``time``, ``duration`` and ROS 1's Header
    :param rules: rules of this and of nested types
    :param default: returns the serialized default of a ROS 2 type, in ROS 1's terms
    :raises MappingError: if fields of either type are unassigned, or rules name unknown fields
    """

    def __init__(
        self,
        first: str,
        fields1: Fields,
        second: str,
        fields2: Fields,
        rules: RulesByType,
        default: Callable[[str], bytes],
    ) -> None:
        self._fields1, self._fields2, self._rules, self._default = fields1, fields2, rules, default
        self._known: Dict[Tuple[str, str], Tuple[_Direction, _Direction]] = {}
        self._errors: List[str] = []
        self._forward, self._back = self._directions(first, second)
        if self._errors:
            raise MappingError("; ".join(dict.fromkeys(self._errors)))

    def to_second(self, data: bytes) -> bytes:
        """Convert a message of the first type to the second.

        :raises ConversionError: if it is not a message of the first type
        """
        return self._forward.convert(data)

    def to_first(self, data: bytes) -> bytes:
        """Convert a message of the second type to the first.

        :raises ConversionError: if it is not a message of the second type
        """
        return self._back.convert(data)

    @property
    def is_copy(self) -> bool:
        """Whether both types have the same fields in the same order, and no rule has an effect."""
        return self._forward.is_copy  # and then the reverse is a copy, too

    def _directions(self, first: str, second: str) -> Tuple[_Direction, _Direction]:
        if (first, second) not in self._known:
            self._known[first, second] = self._compile(first, second)
        return self._known[first, second]

    def _compile(self, first: str, second: str) -> Tuple[_Direction, _Direction]:
        leaves1, leaves2 = leaves(self._fields1, first), leaves(self._fields2, second)
        paths2 = [leaf.path for leaf in leaves2]
        pair = TypePair(self._fields1, first, self._fields2, second, self._rules)
        targets = [pair.counterpart(leaf.path) for leaf in leaves1]
        self._errors += pair.rule_errors()
        sources: Dict[int, int] = {}  # index in the first by index in the second
        for index, (leaf, target) in enumerate(zip(leaves1, targets)):
            if target is None:
                continue
            if target not in paths2:
                self._errors.append(f"{first}: {leaf.path} has no counterpart {target} in {second}")
            elif paths2.index(target) in sources:
                self._errors.append(f"{second}: {target} has several counterparts in {first}")
            else:
                sources[paths2.index(target)] = index
        left_out = pair.left_out2()
        for index, leaf in enumerate(leaves2):
            is_left_out = is_within(leaf.path, left_out)
            if index in sources and is_left_out:
                self._errors.append(f"{second}: {leaf.path} is left out, but has a counterpart")
            elif index not in sources and not is_left_out:
                self._errors.append(f"{second}: {leaf.path} has no counterpart in {first}")
        skips1 = [_skip(leaf.field, self._fields1) for leaf in leaves1]
        skips2 = [_skip(leaf.field, self._fields2) for leaf in leaves2]
        defaults = self._defaults(second, skips2) if len(sources) < len(leaves2) else []
        parts1 = [_Part(None, _zero(leaf.field, self._fields1), None) for leaf in leaves1]
        parts2 = [_Part(None, default, None) for default in defaults or [b""] * len(leaves2)]
        for its, ours in sources.items():
            down, up = self._converters(first, second, leaves1[ours], leaves2[its])
            parts2[its], parts1[ours] = _Part(ours, b"", down), _Part(its, b"", up)
        return _Direction(skips1, parts2), _Direction(skips2, parts1)

    def _defaults(self, second: str, skips: List[_Skip]) -> List[bytes]:
        data, at, found = self._default(second), 0, []
        for skip in skips:
            end = skip(data, at)
            found.append(data[at:end])
            at = end
        return found

    def _converters(
        self, first: str, second: str, ours: Leaf, its: Leaf
    ) -> Tuple[Optional[_Convert], Optional[_Convert]]:
        """Return the converters of a field in both directions; None to copy it."""
        one, other = ours.field, its.field
        if not _are_alike(one, other, self._fields1, self._fields2):
            text = f"{first}: {ours.path} and {its.path} of {second} have different types"
            self._errors.append(text)
        elif one.base in self._fields1:
            forward, back = self._directions(one.base, other.base)
            if not forward.is_copy:
                return _each(forward, one.length), _each(back, one.length)
        return None, None


def unassigned(
    first: str, fields1: Fields, second: str, fields2: Fields, rules: RulesByType
) -> Tuple[List[str], List[str]]:
    """Return the paths of fields of both types that have no counterpart yet, for a draft of a rule.

    :param first, fields1, second, fields2, rules: as of :class:`FieldMapping`
    """
    pair = TypePair(fields1, first, fields2, second, rules)
    theirs = {leaf.path: leaf.field for leaf in leaves(fields2, second)}
    left_out1 = []
    for path, field in leaves(fields1, first):
        target = pair.counterpart(path)
        its = theirs.get(target or "")
        if its is not None and _are_alike(field, its, fields1, fields2):
            del theirs[target or ""]
        elif target is not None:
            left_out1.append(path)
    done = pair.left_out2()
    return left_out1, [path for path in theirs if not is_within(path, done)]


def _are_alike(one: Field, other: Field, fields1: Fields, fields2: Fields) -> bool:
    """Return whether fields can be converted, if their elements can that are messages."""
    same_array = (one.is_array, one.length) == (other.is_array, other.length)
    nested = one.base in fields1 and other.base in fields2
    return same_array and (
        nested or _ALIASES.get(one.base, one.base) == _ALIASES.get(other.base, other.base)
    )


def _skip(field: Field, fields: Fields) -> _Skip:
    element, size = _skip_element(field.base, fields)
    if not field.is_array:
        return element
    if field.length is not None:
        return _skip_fixed(element, size, field.length)

    def skip(data: bytes, at: int) -> int:
        (count,) = _COUNT.unpack_from(data, at)
        return _skip_fixed(element, size, count)(data, at + _COUNT.size)

    return skip


def _skip_fixed(element: _Skip, size: Optional[int], count: int) -> _Skip:
    def skip(data: bytes, at: int) -> int:
        if size is not None:
            return at + size * count
        for _ in range(count):  # a count that is too large ends with an error of struct
            at = element(data, at)
        return at

    return skip


def _skip_element(base: str, fields: Fields) -> Tuple[_Skip, Optional[int]]:
    """Return the function for an element, and its size if it is fixed [bytes]."""
    if base == "string":
        return (lambda data, at: at + _COUNT.size + _COUNT.unpack_from(data, at)[0]), None
    size = _fixed_size(Field(base, False, None, ""), fields)
    if size is not None:
        fixed = size
        return (lambda data, at: at + fixed), size
    skips = [_skip(leaf.field, fields) for leaf in leaves(fields, base)]
    return _Direction(skips, []).skip, None


def _fixed_size(field: Field, fields: Fields) -> Optional[int]:
    """Return the size of a field whose size does not depend on its value [bytes]."""
    if field.base == "string" or (field.is_array and field.length is None):
        return None
    size: Optional[int] = SIZES.get(field.base, 2 * _COUNT.size if field.base in TIMES else None)
    if size is None:
        sizes = [_fixed_size(inner, fields) for inner in fields[field.base]]
        size = None if None in sizes else sum(filter(None, sizes))
    return None if size is None else size * (field.length or 1)


def _zero(field: Field, fields: Fields) -> bytes:
    """Return a field of zeros, empty texts and empty arrays."""
    if field.is_array and field.length is None:
        return _COUNT.pack(0)
    if field.base in fields:
        one = b"".join(_zero(inner, fields) for inner in fields[field.base])
    else:
        one = bytes(SIZES.get(field.base, 2 * _COUNT.size if field.base in TIMES else _COUNT.size))
    return one * (field.length or 1)


def _each(direction: _Direction, length: Optional[int]) -> _Convert:
    """Return the converter of an array of messages."""

    def convert(data: bytes) -> bytes:
        at, count = (_COUNT.size, *_COUNT.unpack_from(data)) if length is None else (0, length)
        pieces = [data[:at]]
        for _ in range(count):
            end = direction.skip(data, at)
            pieces.append(direction.convert(data[at:end]))
            at = end
        return b"".join(pieces)

    return convert
