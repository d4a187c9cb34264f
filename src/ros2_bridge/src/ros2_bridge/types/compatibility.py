# Pure: knows no ROS.
"""Comparison of a ROS 1 type with a ROS 2 type, field by field."""

import re
from typing import Callable, Dict, Mapping, Optional, Tuple

from nodekit.message_definitions import SIZES, TIMES, Field, Fields

#: Returns the fields of a ROS 2 type with their types, in rclpy's notation.
Describe = Callable[[str], Mapping[str, str]]

#: Number types of rclpy. Signedness and Booleans need not agree: the bytes are the same.
_NUMBERS = {
    **dict.fromkeys(("boolean", "octet", "int8", "uint8", "char"), "1 byte"),
    **dict.fromkeys(("int16", "uint16"), "2 bytes"),
    **dict.fromkeys(("int32", "uint32"), "4 bytes"),
    **dict.fromkeys(("int64", "uint64"), "8 bytes"),
    **{"float": "float32", "double": "float64"},
}
#: Number types of rclpy that have other names in ROS 1.
_ROS1_NUMBERS = {"boolean": "bool", "octet": "byte", "float": "float32", "double": "float64"}
#: ROS 1's Header, whose `seq` ROS 2's has not.
_HEADER = (
    Field("uint32", False, None, "seq"),
    Field("time", False, None, "stamp"),
    Field("string", False, None, "frame_id"),
)
_SEQUENCE = re.compile(r"sequence<(.*?)(, \d+)?>\Z")
_ARRAY = re.compile(r"(.*)\[(\d+)\]\Z")
_STRING = re.compile(r"string(<\d+>)?\Z")


def difference(datatype: str, fields: Fields, other: str, describe: Describe) -> Optional[str]:
    """Return a description of the first difference, or None.

    :param datatype: the ROS 1 type
    :param fields: its definition
    :param other: the ROS 2 type
    :param describe: returns the fields of a ROS 2 type
    """
    ours = [(f.name, _ours(f.base), f.length if f.is_array else 0) for f in fields[datatype]]
    if datatype == "std_msgs/Header":
        ours = ours[1:]
    theirs = [(name, *_theirs(kind)) for name, kind in describe(other).items()]
    if other in ("builtin_interfaces/Time", "builtin_interfaces/Duration"):
        return None  # ROS 1's primitive time has the same bytes
    for mine, its in zip(ours, theirs):
        if mine[0].lower() != its[0]:
            return f"{datatype} has field {mine[0]} in ROS 1 but {other} has {its[0]} in ROS 2"
        inner = mine[1] if mine[1] in fields else None
        if mine[2] != its[2] or (inner is None and mine[1] != its[1]):
            return f"field {mine[0]} has different types in {datatype} and {other}"
        found = inner and difference(inner, fields, its[1], describe)
        if found:
            return found
    longer = ours[len(theirs) :] or theirs[len(ours) :]
    if longer:
        which = f"{datatype} of ROS 1" if len(ours) > len(theirs) else f"{other} of ROS 2"
        return f"only {which} has field {longer[0][0]}"
    return None


def in_ros1_terms(datatype: str, describe: Describe) -> Fields:
    """Return the definition of a ROS 2 type, and of those it contains, as of a ROS 1 type.

    :param datatype: the ROS 2 type
    :param describe: returns the fields of a ROS 2 type
    :raises ValueError: if a field has a type that ROS 1 lacks, such as wstring
    """
    found: Dict[str, Tuple[Field, ...]] = {}
    if datatype == "std_msgs/Header":
        return {datatype: _HEADER}
    fields = []
    for name, kind in describe(datatype).items():
        base, is_array, length = _parsed(kind)
        base = _ROS1_NUMBERS.get(base, base)
        if base in ("builtin_interfaces/Time", "builtin_interfaces/Duration"):
            base = base.rpartition("/")[2].lower()
        elif "/" in base:
            found.update(in_ros1_terms(base, describe))
        elif base not in SIZES and base != "string":
            raise ValueError(f"{datatype}: {name}: ROS 1 has no type {base}")
        fields.append(Field(base, is_array, length, name))
    return {datatype: tuple(fields), **found}


def _ours(base: str) -> str:
    if base in TIMES:
        return f"builtin_interfaces/{base.capitalize()}"
    if base in SIZES:
        size = SIZES[base]
        return base if base.startswith("float") else f"{size} byte{'s' if size > 1 else ''}"
    return base


def _theirs(kind: str) -> Tuple[str, Optional[int]]:
    """Return the type of an element, and the length of an array, 0 if it is not an array."""
    base, is_array, length = _parsed(kind)
    return _NUMBERS.get(base, base), length if is_array else 0


def _parsed(kind: str) -> Tuple[str, bool, Optional[int]]:
    """Return the type of an element, whether it is in an array, and the array's fixed length."""
    sequence, array = _SEQUENCE.match(kind), _ARRAY.match(kind)
    base, length = kind, None
    if sequence is not None:
        base = sequence.group(1)
    elif array is not None:
        base, length = array.group(1), int(array.group(2))
    base = "string" if _STRING.match(base) else base
    return base, sequence is not None or array is not None, length
