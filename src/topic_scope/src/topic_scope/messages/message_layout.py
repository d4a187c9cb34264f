# Pure: knows no ROS.
"""Layout of a serialized message, parsed from its definition.

Publishers send the definition to each subscriber, and bags store it, so messages can be read whose
package is not installed.
"""

from typing import Any, Dict, Mapping, NamedTuple, Optional, Tuple, Union

from nodekit.message_definitions import DefinitionError, Field, fields_of, parts_of
from topic_scope.messages.constants import ValueNames, value_names


class Scalar(NamedTuple):
    """A number of fixed size.

    :param datatype: its name in definitions
    :param format: its format for the module struct, without byte order
    :param size: bytes
    """

    datatype: str
    format: str
    size: int
    numeric: bool = True


class Text(NamedTuple):
    """String: its length, then its bytes."""

    datatype: str = "string"
    size: Optional[int] = None
    numeric: bool = False


class MessageLayout(NamedTuple):
    """Layout of a message: its fields in sequence.

    :param datatype: name of its type
    :param fields: name and layout of each, in order
    :param size: bytes; None if variable
    :param numeric: whether it contains numbers, at any depth
    :param value_names: names of the values of fields with named values
    """

    datatype: str
    fields: Tuple[Tuple[str, Any], ...]
    size: Optional[int]
    numeric: bool
    value_names: Mapping[str, ValueNames] = {}


class Array(NamedTuple):
    """Array of elements of one layout.

    :param element: their layout
    :param length: number of elements; None if variable
    :param size: bytes; None if variable
    """

    element: Any
    length: Optional[int]
    size: Optional[int]

    @property
    def numeric(self) -> bool:
        """Whether it contains numbers, at any depth."""
        return bool(self.element.numeric)

    @property
    def datatype(self) -> str:
        """Its name in definitions."""
        count = "" if self.length is None else str(self.length)
        return f"{self.element.datatype}[{count}]"


Layout = Union[Scalar, Text, MessageLayout, Array]

SCALARS: Mapping[str, Scalar] = {
    name: Scalar(name, format, size)
    for name, format, size in (
        ("bool", "?", 1),
        ("int8", "b", 1),
        ("byte", "b", 1),
        ("uint8", "B", 1),
        ("char", "B", 1),
        ("int16", "h", 2),
        ("uint16", "H", 2),
        ("int32", "i", 4),
        ("uint32", "I", 4),
        ("int64", "q", 8),
        ("uint64", "Q", 8),
        ("float32", "f", 4),
        ("float64", "d", 8),
        # Seconds and nanoseconds, converted to a value in s.
        ("time", "II", 8),
        ("duration", "ii", 8),
    )
}

#: Deepest nesting of messages, and most fields at all depths; real messages have far fewer.
_DEPTH, _FIELDS = 50, 20000


def layout_of(message_class: Any) -> MessageLayout:
    """Return the layout of a message class, generated or created at run time.

    :param message_class: class of the messages
    :raises DefinitionError: if its definition is malformed
    """
    return parse(message_class._type, message_class._full_text)


def parse(datatype: str, text: str) -> MessageLayout:
    """Parse a definition.

    :param datatype: name of the type, e.g. ``std_msgs/Float32``
    :param text: its definition, followed by the definitions of the types that it uses
    :raises DefinitionError: if it is malformed
    """
    return _Parser(parts_of(datatype, text)).layout_of_message(datatype, 0)


class _Parser:
    def __init__(self, texts: Mapping[str, str]) -> None:
        self._texts = texts
        self._known: Dict[str, MessageLayout] = {}
        self._counts: Dict[str, int] = {}

    def layout_of_message(self, datatype: str, depth: int) -> MessageLayout:
        if datatype not in self._texts:
            raise DefinitionError(f"the type {datatype} is not defined")
        if depth > _DEPTH:
            raise DefinitionError(f"the type {datatype} is nested too deeply")
        if datatype not in self._known:
            declared = fields_of(datatype, self._texts[datatype])
            fields = tuple((field.name, self._layout_of_field(field, depth)) for field in declared)
            sizes = [layout.size for _, layout in fields]
            size = None if None in sizes else sum(sizes)  # type: ignore[arg-type]
            numeric = any(layout.numeric for _, layout in fields)
            self._counts[datatype] = len(fields) + sum(
                self._counts.get(_innermost(layout), 0) for _, layout in fields
            )
            if self._counts[datatype] > _FIELDS:
                raise DefinitionError(f"the type {datatype} has too many fields")
            names = value_names(datatype, self._texts[datatype])
            self._known[datatype] = MessageLayout(datatype, fields, size, numeric, names)
        return self._known[datatype]

    def _layout_of_field(self, field: Field, depth: int) -> Layout:
        layout: Layout
        if field.base in SCALARS:
            layout = SCALARS[field.base]
        elif field.base == "string":
            layout = Text()
        else:
            layout = self.layout_of_message(field.base, depth + 1)
        if field.is_array:
            layout = Array(layout, field.length, _size_of_array(layout, field.length))
        return layout


def _size_of_array(element: Layout, count: Optional[int]) -> Optional[int]:
    if count == 0:
        return 0
    return None if count is None or element.size is None else count * element.size


def _innermost(layout: Layout) -> str:
    return layout.element.datatype if isinstance(layout, Array) else layout.datatype
