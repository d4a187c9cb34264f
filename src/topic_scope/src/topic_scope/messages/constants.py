# Pure: knows no ROS.
"""Names of integer values: the constants beside a field in its definition."""

from typing import Dict, List, Mapping, Optional, Tuple

from nodekit.message_definitions import Constant, Field, constant_in, field_in

#: Names by value.
ValueNames = Mapping[int, str]
#: Integer types.
_WHOLE = ("int8", "uint8", "byte", "char", "int16", "uint16", "int32", "uint32", "int64", "uint64")


def value_names(datatype: str, text: str) -> Dict[str, ValueNames]:
    """Return the names of the values of fields, from the constants of a definition.

    Constants name the values of the field before or after them, whichever has their type. If both
    have it, the definition is ambiguous, and neither has names.

    :param datatype: name of the type
    :param text: its definition, without the definitions of other types
    :returns: by name of the field; a value with several names has all of them
    """
    package = datatype.partition("/")[0]
    found: Dict[str, List[Constant]] = {}
    before: Optional[Field] = None
    between: List[Constant] = []
    for line in [*text.splitlines(), ""]:
        constant, field = constant_in(line), field_in(line, package)
        if constant is not None:
            between.append(constant)
        if field is not None:
            _assign(between, before, field, found)
            before, between = field, []
    _assign(between, before, None, found)
    return {name: _names(constants) for name, constants in found.items()}


def _assign(
    constants: List[Constant],
    before: Optional[Field],
    behind: Optional[Field],
    found: Dict[str, List[Constant]],
) -> None:
    """Add constants to the neighbouring field of their type, if only one has it."""
    for constant in constants:
        beside = [one for one in (before, behind) if one and _fits(one, constant)]
        if len(beside) == 1 and _value(constant) is not None:
            found.setdefault(beside[0].name, []).append(constant)


def _fits(field: Field, constant: Constant) -> bool:
    return not field.is_array and field.base == constant.base and field.base in _WHOLE


def _value(constant: Constant) -> Optional[int]:
    try:
        return int(constant.value, 0)
    except ValueError:
        return None


def _names(constants: List[Constant]) -> ValueNames:
    pairs: List[Tuple[Optional[int], str]] = [(_value(one), one.name) for one in constants]
    values = dict.fromkeys(value for value, _ in pairs if value is not None)
    return {one: " or ".join(name for value, name in pairs if value == one) for one in values}
