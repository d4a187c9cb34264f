# Pure: knows no ROS.
"""Numbers in messages, named by their topic and their place: ``/motor_output/output``. Pure."""

import re
from typing import Any, Collection, List, NamedTuple

#: A part of a name: a field, or an element of one.
_PART = re.compile(r"([A-Za-z]\w*)(?:\[(\d+)\])?\Z", re.ASCII)


class FieldError(ValueError):
    """A field that is not there; the text says why."""


class Field(NamedTuple):
    """A number in the messages of a topic.

    :ivar topic: global name
    :ivar path: names of fields, each with ``[n]`` behind it where it is an element
    """

    topic: str
    path: str

    def __str__(self) -> str:
        return f"{self.topic}/{self.path}"


def field_of(name: str, topics: Collection[str]) -> Field:
    """Return the field that a name stands for.

    :param name: topic and place in its messages
    :param topics: global names of those that there are
    :raises FieldError: if none of them is meant
    """
    whole = "/" + name.strip("/")
    fitting = [topic for topic in topics if whole.startswith(topic + "/")]
    if not fitting:
        there = ", ".join(sorted(topics)) or "none"
        raise FieldError(f"{name}: there is no such topic; there are: {there}")
    topic = max(fitting, key=len)
    return Field(topic, whole[len(topic) + 1 :])


def number_in(message: Any, field: Field) -> float:
    """Return the number that a field of a message is.

    :param message: of ROS
    :param field: of its topic
    :raises FieldError: if there is no such number
    """
    value = message
    for part in field.path.split("/"):
        value = _part_of(value, part, field)
    if not isinstance(value, (int, float)):
        raise FieldError(f"{field} is not a number{_hint(value)}")
    return float(value)


def put_number(message: Any, field: Field, value: float) -> None:
    """Set the number that a field of a message is.

    :param message: of ROS
    :param field: of its topic; the last part is no element
    :param value: what it is set to
    :raises FieldError: if there is no such number
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
        raise FieldError(f"{field}: there is no {part!r}{_hint(value)}")
    value = getattr(value, match.group(1))
    if match.group(2) is None:
        return value
    if not isinstance(value, (list, tuple)) or int(match.group(2)) >= len(value):
        raise FieldError(f"{field}: there is no {part!r}: it is no element of an array")
    return value[int(match.group(2))]


def _hint(value: Any) -> str:
    names: List[str] = list(getattr(value, "__slots__", ()))
    return f"; it has: {', '.join(names)}" if names else ""
