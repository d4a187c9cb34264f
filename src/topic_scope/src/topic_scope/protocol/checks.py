# Pure: knows no ROS.
"""Validation of the fields of a request."""

import math
from typing import Any, Dict, List, Tuple

from topic_scope.formulas.names import expand, is_state
from topic_scope.messages.fields import FieldError

#: Most traces of a page.
TRACES = 32
#: Range of valid times [s] since the epoch.
TIMES = (0.0, 1e11)
_LONGEST_NAME = 300


class RequestError(ValueError):
    """Invalid or impossible request; the text states the reason."""


def fields_of(names: Any) -> Tuple[str, ...]:
    """Return the field names of a list.

    :param names: the received value
    :returns: each name once
    :raises RequestError: if it is not a list of names
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
    """Check the number of traces.

    :raises RequestError: if there are too many
    """
    if count > TRACES:
        raise RequestError(f"a page shows at most {TRACES} traces, not {count}")


def field_names(name: Any, kind: str) -> List[str]:
    """Return the fields that a name denotes.

    An invalid name is returned unchanged, so that its row shows why it has no samples, and the
    other traces are shown.

    :param name: the received value
    :param kind: type of the request, for the error
    :raises RequestError: if it is not a string
    """
    if not isinstance(name, str):
        raise RequestError(f"{kind}: the name of a field must be a text")
    try:
        return expand(name)
    except FieldError:
        return [name]


def field_in(request: Dict[str, Any], kind: str, key: str = "field") -> str:
    """Return the single field that a request names.

    :raises RequestError: if the name is invalid, or denotes several fields
    """
    fields = field_names(request.get(key), kind)
    if len(fields) != 1:
        raise RequestError(f"{kind}: {key} must be one field")
    if is_state(fields[0]):
        raise RequestError(f"{kind}: {fields[0]} is a state: {key} must be a number")
    return fields[0]


def time_of(text: Any) -> float:
    """Return a time.

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
    """Return a keyword in a request.

    :raises RequestError: if it is not one of the allowed keywords
    """
    word = request.get(key)
    if not isinstance(word, str) or word not in words:
        raise RequestError(f"{kind}: {key} must be one of {', '.join(words)}")
    return word


def flag_of(request: Dict[str, Any], kind: str, key: str) -> bool:
    """Return a Boolean in a request.

    :raises RequestError: if it is not one
    """
    flag = request.get(key)
    if not isinstance(flag, bool):
        raise RequestError(f"{kind}: {key} must be true or false")
    return flag


def number_of(request: Dict[str, Any], kind: str, key: str, low: float, high: float) -> float:
    """Return a number in a request.

    :raises RequestError: if it is not a number, or is out of range
    """
    number = request.get(key)
    if isinstance(number, bool) or not isinstance(number, (int, float)):
        raise RequestError(f"{kind}: {key} must be a number")
    if not low <= number <= high or not math.isfinite(number):
        raise RequestError(f"{kind}: {key} must be a number from {low:g} to {high:g}")
    return float(number)
