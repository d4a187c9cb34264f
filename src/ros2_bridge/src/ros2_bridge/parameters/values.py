# Pure: knows no ROS.
"""Parameter values of ROS 2: types, ranges, dotted names; imports neither ROS."""

import math
import sys
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple

import numpy

NOT_SET, BOOL, INTEGER, DOUBLE, STRING = 0, 1, 2, 3, 4
BYTES, BOOLS, INTEGERS, DOUBLES, STRINGS = 5, 6, 7, 8, 9
#: Field of a ParameterValue, by type.
FIELDS = {
    BOOL: "bool_value",
    INTEGER: "integer_value",
    DOUBLE: "double_value",
    STRING: "string_value",
    BYTES: "byte_array_value",
    BOOLS: "bool_array_value",
    INTEGERS: "integer_array_value",
    DOUBLES: "double_array_value",
    STRINGS: "string_array_value",
}
_DECLARED = {"bool": BOOL, "int": INTEGER, "float": DOUBLE, "str": STRING, "enum": STRING}
_ARRAYS = {BOOL: BOOLS, INTEGER: INTEGERS, DOUBLE: DOUBLES, STRING: STRINGS}
#: Floating-point types that integers are accepted for.
DOUBLE_FOR = {INTEGER: DOUBLE, INTEGERS: DOUBLES}
#: Range of integers on the ROS 1 parameter server.
LOWEST, HIGHEST = -(2**31), 2**31 - 1
#: Largest limit of a range in ROS 2.
LARGEST = sys.float_info.max


def kind_of(value: Any) -> int:
    """Return the type of a plain value; NOT_SET if ROS 2 has no such type."""
    if isinstance(value, bool):
        return BOOL
    if isinstance(value, (int, float)):
        return INTEGER if isinstance(value, int) else DOUBLE
    if isinstance(value, str):
        return STRING
    if isinstance(value, (list, tuple)):
        kinds = {kind_of(one) for one in value}
        if kinds == {INTEGER, DOUBLE}:
            return DOUBLES
        return _ARRAYS.get(min(kinds), NOT_SET) if len(kinds) == 1 else NOT_SET
    return NOT_SET


def declared_kind(entry: Mapping[str, Any]) -> int:
    """Return the type of a parameter, from an entry of a node's description."""
    if entry["type"] == "list":
        return _ARRAYS.get(_DECLARED.get(entry["element"]["type"], STRING), STRINGS)
    return _DECLARED.get(entry["type"], STRING)


def as_kind(value: Any, kind: int) -> Any:
    """Return a value converted to a type: ROS 1 may hold an integer for another type."""
    if kind == DOUBLE:
        return float(value)
    if kind == DOUBLES:
        return [float(one) for one in value]
    if kind == BYTES:
        return [bytes([one]) for one in value]
    return list(value) if isinstance(value, tuple) else value


def fitting_kind(value: Any, kind: int) -> int:
    """Return the type with which to set a parameter to a ROS 1 value.

    ROS 1 uses integers for bytes, and an empty list has no element type.
    """
    found = kind_of(value)
    if (kind, found) == (BYTES, INTEGERS) or (kind >= BYTES and value == []):
        return kind
    return found


def unfit(name: str, value: Any) -> str:
    """Return why ROS 1 cannot carry the value of a parameter; empty if it can."""
    for one in value if isinstance(value, list) else [value]:
        if one is None:
            return f"{name} cannot be removed: ROS 1's nodes keep their parameters"
        if type(one) is int and not LOWEST <= one <= HIGHEST:
            return f"{name}: refused {one}: ROS 1 carries integers of 32 bits only"
        if type(one) is str and any(ord(sign) < 32 and sign not in "\t\n" for sign in one):
            return f"{name}: refused {one!r}: ROS 1 carries no control characters"
    return ""


def flat(tree: Mapping[str, Any], prefix: str = "") -> Dict[str, Any]:
    """Return the parameters below a ROS 1 namespace, by ROS 2 name."""
    found: Dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, dict):
            found.update(flat(value, f"{prefix}{name}."))
        else:
            found[prefix + name] = value
    return found


def ros1_key(name: str) -> str:
    """Return the ROS 1 name of a ROS 2 parameter."""
    return name.replace(".", "/")


class Range(NamedTuple):
    """Range of numbers: from, to and step; step 0 for none."""

    low: Any
    high: Any
    step: Any


def range_of(entry: Mapping[str, Any]) -> Optional[Range]:
    """Return the exact range of a number; an open end becomes the adjacent number.

    :param entry: from a node's description
    """
    keys = ("minimum", "above", "maximum", "below", "step")
    minimum, above, maximum, below, step = (entry.get(key) for key in keys)
    if entry["type"] not in ("int", "float") or {minimum, above, maximum, below, step} == {None}:
        return None
    is_whole = entry["type"] == "int"
    low, high = (LOWEST, HIGHEST) if is_whole else (-LARGEST, LARGEST)
    if minimum is not None:
        low = minimum
    if above is not None:
        low = math.floor(above) + 1 if is_whole else numpy.nextafter(above, math.inf)
    if maximum is not None:
        high = maximum
    if below is not None:
        high = math.ceil(below) - 1 if is_whole else numpy.nextafter(below, -math.inf)
    if is_whole:
        return Range(low, high, int(step or 1))
    return Range(float(low), float(high), float(step or 0.0))


def description_of(entry: Mapping[str, Any]) -> Tuple[str, str]:
    """Return the description of a parameter, and its constraints, as text."""
    unit = f" ({entry['unit']})" if entry.get("unit") else ""
    allowed: List[str] = []
    if entry.get("choices"):
        allowed.append("one of " + ", ".join(map(str, entry["choices"])))
    elif entry.get("range"):
        allowed.append(str(entry["range"]))
    if not entry.get("exact", True):
        allowed.append("and further checks when it is set")
    return f"{entry.get('help', '')}{unit}", "; ".join(allowed)


def is_same(one: Any, other: Any) -> bool:
    """Return whether two values are equal, also in type; NaN equals itself here.

    :param one: a plain value, or its message
    :param other: another
    """
    return repr(one) == repr(other)


def changes(
    old: Mapping[str, Any], new: Mapping[str, Any]
) -> Tuple[Dict[str, Any], Dict[str, Any], Dict[str, Any]]:
    """Return the new, changed and deleted entries, each with its value."""
    fresh = {name: value for name, value in new.items() if name not in old}
    gone = {name: value for name, value in old.items() if name not in new}
    changed = {
        name: value for name, value in new.items() if name in old and not is_same(value, old[name])
    }
    return fresh, changed, gone


def differs(server: Mapping[str, Any], in_force: Mapping[str, Any]) -> bool:
    """Return whether the server holds a value that is not in force."""
    return any(
        name in server and server[name] != value and not is_same(server[name], value)
        for name, value in in_force.items()
    )


def listed(names: List[str], prefixes: List[str], depth: int) -> Tuple[List[str], List[str]]:
    """Answer ROS 2's ListParameters: names, and prefixes of names with a dot.

    :param prefixes: prefixes of the wanted names; empty for all
    :param depth: most parts of a name behind its prefix; 0 for any
    """

    def fits(name: str) -> bool:
        if not prefixes:
            return not depth or name.count(".") < depth
        return any(
            name == prefix
            or name.startswith(prefix + ".")
            and (not depth or name[len(prefix) + 1 :].count(".") < depth)
            for prefix in prefixes
        )

    found = [name for name in names if fits(name)]
    return found, sorted({name.rpartition(".")[0] for name in found if "." in name})
