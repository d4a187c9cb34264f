# Pure: knows no ROS.
"""Access to numeric message fields by topic and path, such as ``/motor_output/output``."""

import re
from typing import Any, Collection, List, NamedTuple

#: One part of a path: a field, or an element of an array.
_PART = re.compile(r"([A-Za-z]\w*)(?:\[(\d+)\])?\Z", re.ASCII)


class FieldError(ValueError):
    """Error of a field that is missing or not a number; the text gives the reason."""


class Field(NamedTuple):
    """A numeric field in the messages of a topic.

    :ivar topic: global name
    :ivar path: field names, followed by ``[n]`` for an element of an array
    """

    topic: str
    path: str

    def __str__(self) -> str:
        return f"{self.topic}/{self.path}"


def field_of(name: str, topics: Collection[str]) -> Field:
    """Parse the name of a field.

    :param name: topic and path in its messages
    :param topics: global names of the existing topics
    :raises FieldError: if the name does not begin with one of them
    """
    whole = "/" + name.strip("/")
    fitting = [topic for topic in topics if whole.startswith(topic + "/")]
    if not fitting:
        there = ", ".join(sorted(topics)) or "none"
        raise FieldError(f"{name}: unknown topic; choose one of: {there}")
    topic = max(fitting, key=len)
    return Field(topic, whole[len(topic) + 1 :])


def number_in(message: Any, field: Field) -> float:
    """Return the value of a field.

    :param message: a ROS message
    :param field: a field of its topic
    :raises FieldError: if the field is missing or not a number
    """
    value = message
    for part in field.path.split("/"):
        value = _part_of(value, part, field)
    if not isinstance(value, (int, float)):
        raise FieldError(f"{field} is not a number{_hint(value)}")
    return float(value)


def put_number(message: Any, field: Field, value: float) -> None:
    """Set the value of a field.

    :param message: a ROS message
    :param field: a field of its topic, not an element of an array
    :param value: the new value
    :raises FieldError: if the field is missing or not a number
    """
    number_in(message, field)
    *before, last = field.path.split("/")
    for part in before:
        message = _part_of(message, part, field)
    if last not in message.__slots__:
        raise FieldError(f"{field}: an element cannot be set")
    setattr(message, last, type(getattr(message, last))(value))


def _part_of(value: Any, part: str, field: Field) -> Any:
    match = _PART.match(part)
    if match is None or match.group(1) not in getattr(value, "__slots__", ()):
        raise FieldError(f"{field}: unknown field {part!r}{_hint(value)}")
    value = getattr(value, match.group(1))
    if match.group(2) is None:
        return value
    if not isinstance(value, (list, tuple)) or int(match.group(2)) >= len(value):
        raise FieldError(f"{field}: {part!r} is not an element of an array")
    return value[int(match.group(2))]


def _hint(value: Any) -> str:
    names: List[str] = list(getattr(value, "__slots__", ()))
    return f"; it has: {', '.join(names)}" if names else ""
