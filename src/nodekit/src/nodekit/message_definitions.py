# Pure: knows no ROS.
"""What the definition of a message says, line by line; its notation: http://wiki.ros.org/msg.

It is read, and no code is made of it: it may come from somebody else. Pure: it knows no ROS.
"""

import re
from typing import Dict, List, NamedTuple, Optional, Tuple

#: Bytes of each number, by its name in definitions.
SIZES: Dict[str, int] = {
    **dict.fromkeys(("bool", "int8", "uint8", "byte", "char"), 1),
    **dict.fromkeys(("int16", "uint16"), 2),
    **dict.fromkeys(("int32", "uint32", "float32"), 4),
    **dict.fromkeys(("int64", "uint64", "float64"), 8),
}
#: Two numbers of 4 bytes each: seconds and nanoseconds.
TIMES = ("time", "duration")

_SEPARATOR = re.compile(r"^={80}\s*$", re.MULTILINE)
_FIELD = re.compile(r"([A-Za-z][\w/]*)(\[(\d*)\])?\s+([A-Za-z]\w*)\Z", re.ASCII)
_CONSTANT = re.compile(r"([a-z]\w*)\s+([A-Za-z]\w*)\s*=(.*)", re.ASCII)


class DefinitionError(ValueError):
    """A malformed definition."""


class Field(NamedTuple):
    """A field of a message.

    :param base: its type, of an array that of an element; messages with their package
    :param is_array: whether it is one
    :param length: of an array of fixed length, otherwise None
    """

    base: str
    is_array: bool
    length: Optional[int]
    name: str


class Constant(NamedTuple):
    """A constant, with its value as it is written."""

    base: str
    name: str
    value: str


def constant_in(line: str) -> Optional[Constant]:
    """Return the constant that a line declares, None where it declares none."""
    match = _CONSTANT.match(line.strip())
    if match is None:
        return None
    base, name, value = match.groups()
    # The text of a constant is all that follows, a "#" too.
    return Constant(base, name, (value if base == "string" else value.partition("#")[0]).strip())


def field_in(line: str, package: str) -> Optional[Field]:
    """Return the field that a line declares, None where it declares none.

    :param line: of a definition
    :param package: whose definition it is
    :raises DefinitionError: if it is malformed
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
    """Read a definition together with those of the types that it uses.

    :param datatype: its type, such as ``std_msgs/Header``
    :param text: as ``rosmsg show --raw`` has it, or a connection's header
    :raises DefinitionError: if it is malformed
    """
    found = {name: fields_of(name, body) for name, body in parts_of(datatype, text).items()}
    _check_defined(datatype, found, [])
    return found


def parts_of(datatype: str, text: str) -> Dict[str, str]:
    """Take a definition apart, which those of the types that it uses follow.

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

    :param datatype: its type
    :param text: its own text only
    :raises DefinitionError: if it is malformed
    """
    package = datatype.partition("/")[0]
    lines: List[Optional[Field]] = [field_in(line, package) for line in text.splitlines()]
    return tuple(line for line in lines if line is not None)


def _check_defined(datatype: str, found: Fields, within: List[str]) -> None:
    if datatype in within:
        raise DefinitionError(f"the type {datatype} contains itself")
    if datatype not in found:
        raise DefinitionError(f"the type {datatype} is not defined")
    for field in found[datatype]:
        if "/" in field.base:
            _check_defined(field.base, found, [*within, datatype])
