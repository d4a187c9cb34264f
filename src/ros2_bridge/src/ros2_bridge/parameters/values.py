# Pure: knows no ROS.
"""Parameter values of ROS 2: type numbers, ranges, dotted names; imports neither ROS."""

import math
import sys
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple

import numpy

NOT_SET, BOOL, INTEGER, DOUBLE, STRING = 0, 1, 2, 3, 4
BYTES, BOOLS, INTEGERS, DOUBLES, STRINGS = 5, 6, 7, 8, 9
#: The field of a ParameterValue that holds a value, by its kind.
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
#: The kind that a kind of whole numbers may be taken for.
DOUBLE_FOR = {INTEGER: DOUBLE, INTEGERS: DOUBLES}
#: What a parameter server of ROS 1 takes for whole numbers.
LOWEST, HIGHEST = -(2**31), 2**31 - 1
#: The largest number that ROS 2 has for a range.
LARGEST = sys.float_info.max


def kind_of(value: Any) -> int:
    """Return the kind of a plain value; NOT_SET where ROS 2 has none for it."""
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
    """Return the kind of a parameter by an entry of a node's description."""
    if entry["type"] == "list":
        return _ARRAYS.get(_DECLARED.get(entry["element"]["type"], STRING), STRINGS)
    return _DECLARED.get(entry["type"], STRING)


def as_kind(value: Any, kind: int) -> Any:
    """Return a value as its kind has it: a whole number may stand for another one in ROS 1."""
    if kind == DOUBLE:
        return float(value)
    if kind == DOUBLES:
        return [float(one) for one in value]
    if kind == BYTES:
        return [bytes([one]) for one in value]
    return list(value) if isinstance(value, tuple) else value


def fitting_kind(value: Any, kind: int) -> int:
    """Return as which kind a value of ROS 1 is given to a parameter of a kind.

    ROS 1 has whole numbers for bytes, and an empty list has no type of elements.
    """
    found = kind_of(value)
    if (kind, found) == (BYTES, INTEGERS) or (kind >= BYTES and value == []):
        return kind
    return found


def unfit(name: str, value: Any) -> str:
    """Return why ROS 1 cannot carry the value of a parameter; empty where it can."""
    for one in value if isinstance(value, list) else [value]:
        if one is None:
            return f"{name} cannot be removed: ROS 1's nodes keep their parameters"
        if type(one) is int and not LOWEST <= one <= HIGHEST:
            return f"{name}: refused {one}: ROS 1 carries integers of 32 bits only"
        if type(one) is str and any(ord(sign) < 32 and sign not in "\t\n" for sign in one):
            return f"{name}: refused {one!r}: ROS 1 carries no control characters"
    return ""


def flat(tree: Mapping[str, Any], prefix: str = "") -> Dict[str, Any]:
    """Return the parameters below a namespace of ROS 1, by their names in ROS 2."""
    found: Dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, dict):
            found.update(flat(value, f"{prefix}{name}."))
        else:
            found[prefix + name] = value
    return found


def ros1_key(name: str) -> str:
    """Return the name in ROS 1 of a parameter of ROS 2."""
    return name.replace(".", "/")


class Range(NamedTuple):
    """Range of numbers: from, to and step, 0 for any."""

    low: Any
    high: Any
    step: Any


def range_of(entry: Mapping[str, Any]) -> Optional[Range]:
    """Return the range of a number, exactly: an open end is the number next to it.

    :param entry: of a node's description
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
    """Return what a parameter is, in words, and what is allowed."""
    unit = f" ({entry['unit']})" if entry.get("unit") else ""
    allowed: List[str] = []
    if entry.get("choices"):
        allowed.append("one of " + ", ".join(map(str, entry["choices"])))
    elif entry.get("range"):
        allowed.append(str(entry["range"]))
    if not entry.get("exact", True):
        allowed.append("and what the node says when it is set")
    return f"{entry.get('help', '')}{unit}", "; ".join(allowed)


def is_same(one: Any, other: Any) -> bool:
    """Tell whether two values are alike, also in kind; NaN is, which does not equal itself.

    :param one: a plain value, or the message of one
    :param other: another
    """
    return repr(one) == repr(other)


def changes(
    old: Mapping[str, Any], new: Mapping[str, Any]
) -> Tuple[Dict[str, Any], Dict[str, Any], Dict[str, Any]]:
    """Return what is new, what has changed and what has gone, each with its value."""
    fresh = {name: value for name, value in new.items() if name not in old}
    gone = {name: value for name, value in old.items() if name not in new}
    changed = {
        name: value for name, value in new.items() if name in old and not is_same(value, old[name])
    }
    return fresh, changed, gone


def differs(server: Mapping[str, Any], in_force: Mapping[str, Any]) -> bool:
    """Tell whether the server holds another value than the one in force."""
    return any(
        name in server and server[name] != value and not is_same(server[name], value)
        for name, value in in_force.items()
    )


def listed(names: List[str], prefixes: List[str], depth: int) -> Tuple[List[str], List[str]]:
    """Answer ROS 2's ListParameters: names, and the prefixes of those with a dot.

    :param prefixes: what the names are to begin with, none for all
    :param depth: how many parts of a name there may be, behind the prefix; 0 for any
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
