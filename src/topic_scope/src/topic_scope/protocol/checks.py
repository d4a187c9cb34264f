# Pure: knows no ROS.
"""Checks of the parts of a request."""

import math
from typing import Any, Dict, List, Tuple

from topic_scope.formulas.names import expand, is_state
from topic_scope.messages.fields import FieldError

#: Most traces of a page.
TRACES = 32
#: Times that there are [s] since the epoch.
TIMES = (0.0, 1e11)
_LONGEST_NAME = 300


class RequestError(ValueError):
    """A request that cannot be obeyed, and why."""


def fields_of(names: Any) -> Tuple[str, ...]:
    """Read a list of names of fields.

    :param names: as it came
    :returns: each name once
    :raises RequestError: if it is not such a list
    """
    if not isinstance(names, list):
        raise RequestError("fields must be a list of names")
    check_count(len(names))
    fields: List[str] = []
    for name in names:
        fields += [field for field in field_names(name, "fields") if field not in fields]
    check_count(len(fields))
    return tuple(fields)


def check_count(count: int) -> None:
    """Check how many traces there are to be.

    :raises RequestError: if these are too many
    """
    if count > TRACES:
        raise RequestError(f"a page shows at most {TRACES} traces, not {count}")


def field_names(name: Any, kind: str) -> List[str]:
    """Return the fields that a name stands for.

    What is not a name stays as it is: so it has a row of its own that says why there is nothing,
    and the others are shown.

    :param name: as it came
    :param kind: what it is needed for
    :raises RequestError: if it is not a text
    """
    if not isinstance(name, str):
        raise RequestError(f"{kind}: the name of a field must be a text")
    try:
        return expand(name)
    except FieldError:
        return [name]


def field_in(request: Dict[str, Any], kind: str, key: str = "field") -> str:
    """Return the one field that a request names.

    :raises RequestError: if it is not a name, or stands for several
    """
    fields = field_names(request.get(key), kind)
    if len(fields) != 1:
        raise RequestError(f"{kind}: {key} must be one field")
    if is_state(fields[0]):
        raise RequestError(f"{kind}: {fields[0]} is a state: {key} must be a number")
    return fields[0]


def time_of(text: Any) -> float:
    """Read a time.

    :param text: s since the epoch
    :raises RequestError: if it is invalid
    """
    try:
        time = float(text)
    except (TypeError, ValueError):
        time = math.nan
    if not TIMES[0] <= time <= TIMES[1]:
        raise RequestError("a time must be a number of seconds since the epoch")
    return time


def name_of(request: Dict[str, Any], kind: str, key: str) -> str:
    """Return a name in a request.

    :raises RequestError: if it is invalid
    """
    name = request.get(key)
    if not isinstance(name, str) or not 0 < len(name) <= _LONGEST_NAME:
        raise RequestError(f"{kind}: {key} must be a name")
    return name


def word_of(request: Dict[str, Any], kind: str, key: str, words: Tuple[str, ...]) -> str:
    """Return one of some words in a request.

    :raises RequestError: if it is not one of them
    """
    word = request.get(key)
    if not isinstance(word, str) or word not in words:
        raise RequestError(f"{kind}: {key} must be one of {', '.join(words)}")
    return word


def flag_of(request: Dict[str, Any], kind: str, key: str) -> bool:
    """Return a truth value in a request.

    :raises RequestError: if it is not one
    """
    flag = request.get(key)
    if not isinstance(flag, bool):
        raise RequestError(f"{kind}: {key} must be true or false")
    return flag


def number_of(request: Dict[str, Any], kind: str, key: str, low: float, high: float) -> float:
    """Return a number in a request.

    :raises RequestError: if it is not a number, or out of range
    """
    number = request.get(key)
    if isinstance(number, bool) or not isinstance(number, (int, float)):
        raise RequestError(f"{kind}: {key} must be a number")
    if not low <= number <= high or not math.isfinite(number):
        raise RequestError(f"{kind}: {key} must be a number from {low:g} to {high:g}")
    return float(number)
