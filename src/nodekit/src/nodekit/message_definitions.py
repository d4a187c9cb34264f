# Pure: knows no ROS.
"""Parser of message definitions, in the notation of http://wiki.ros.org/msg.

It generates no code, because a definition may come from an untrusted node. Pure: it knows no ROS.
"""

import re
from typing import Dict, List, NamedTuple, Optional, Set, Tuple

#: Size of each numeric type [bytes].
SIZES: Dict[str, int] = {
    **dict.fromkeys(("bool", "int8", "uint8", "byte", "char"), 1),
    **dict.fromkeys(("int16", "uint16"), 2),
    **dict.fromkeys(("int32", "uint32", "float32"), 4),
    **dict.fromkeys(("int64", "uint64", "float64"), 8),
}
#: Types of two numbers of 4 bytes each: seconds and nanoseconds.
TIMES = ("time", "duration")

_SEPARATOR = re.compile(r"^={80}\s*$", re.MULTILINE)
_FIELD = re.compile(r"([A-Za-z][\w/]*)(\[(\d*)\])?\s+([A-Za-z]\w*)\Z", re.ASCII)
_CONSTANT = re.compile(r"([a-z]\w*)\s+([A-Za-z]\w*)\s*=(.*)", re.ASCII)


class DefinitionError(ValueError):
    """Error of a malformed definition."""


class Field(NamedTuple):
    """Field of a message.

    :param base: type, or element type of an array; message types include their package
    :param is_array: whether the field is an array
    :param length: length of an array of fixed length, otherwise None
    """

    base: str
    is_array: bool
    length: Optional[int]
    name: str


class Constant(NamedTuple):
    """Constant, with its value as written in the definition."""

    base: str
    name: str
    value: str


def constant_in(line: str) -> Optional[Constant]:
    """Return the constant that a line declares, None for any other line."""
    match = _CONSTANT.match(line.strip())
    if match is None:
        return None
    base, name, value = match.groups()
    # A string constant takes the rest of the line, including a "#".
    return Constant(base, name, (value if base == "string" else value.partition("#")[0]).strip())


def field_in(line: str, package: str) -> Optional[Field]:
    """Return the field that a line declares, None for any other line.

    :param line: line of a definition
    :param package: package of the definition
    :raises DefinitionError: if the line is malformed
    """
    code = line.partition("#")[0].strip()
    if not code or constant_in(line):
        return None
    match = _FIELD.match(code)
    if match is None:
        raise DefinitionError(f"{line.strip()!r} is not a field of a message")
    base, brackets, length, name = match.groups()
    if base in ("Header", "roslib/Header"):
        base = "std_msgs/Header"
    elif base not in SIZES and base not in TIMES and base != "string" and "/" not in base:
        base = f"{package}/{base}"
    return Field(base, brackets is not None, int(length) if length else None, name)


#: Types and their fields.
Fields = Dict[str, Tuple[Field, ...]]


def parse(datatype: str, text: str) -> Fields:
    """Parse a definition together with those of the types that it uses.

    :param datatype: type, such as ``std_msgs/Header``
    :param text: definition as in ``rosmsg show --raw``, or in a connection header
    :raises DefinitionError: if the definition is malformed
    """
    found = {name: fields_of(name, body) for name, body in parts_of(datatype, text).items()}
    _check_defined(datatype, found, [], set())
    return found


def parts_of(datatype: str, text: str) -> Dict[str, str]:
    """Split a definition that is followed by those of the types that it uses.

    :returns: the text of each type, by its name
    :raises DefinitionError: if a part has no name
    """
    first, *others = _SEPARATOR.split(text)
    texts = {datatype: first}
    for other in others:
        head, _, body = other.strip().partition("\n")
        if not head.startswith("MSG:"):
            raise DefinitionError(f"no name is given to a part of the definition of {datatype}")
        texts[head[len("MSG:") :].strip()] = body
    return texts


def fields_of(datatype: str, text: str) -> Tuple[Field, ...]:
    """Return the fields that one definition declares.

    :param datatype: type
    :param text: text of this type only
    :raises DefinitionError: if the definition is malformed
    """
    package = datatype.partition("/")[0]
    lines: List[Optional[Field]] = [field_in(line, package) for line in text.splitlines()]
    return tuple(line for line in lines if line is not None)


def _check_defined(datatype: str, found: Fields, within: List[str], checked: Set[str]) -> None:
    if datatype in within:
        raise DefinitionError(f"the type {datatype} contains itself")
    if datatype not in found:
        raise DefinitionError(f"the type {datatype} is not defined")
    for field in found[datatype]:
        if "/" in field.base and field.base not in checked:
            _check_defined(field.base, found, [*within, datatype], checked)
    checked.add(datatype)
