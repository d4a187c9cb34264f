"""Numbers in messages that are objects, as those of a bag are."""

from typing import Any, Callable

from topic_scope.messages.fields import Key, Lengths, Path


def lengths_in(message: Any) -> Lengths:
    """Return the function that tells how long the arrays of a message are."""
    return lambda path: len(value_at(message, path) or ())


def value_at(message: Any, path: Path) -> Any:
    """Return what stands in a message as it is: a time, say, or a whole number.

    :param message: the message
    :param path: where it stands
    :returns: the value; None where an array is too short for it, or none of its elements has the
        name
    """
    around = value = message
    for part in path:
        if isinstance(part, Key):
            part = around.name.index(part) if part in around.name else len(value)
        if isinstance(part, str):
            around, value = value, getattr(value, part)
        elif part < len(value):
            value = value[part]
        else:
            return None
    return value


def getter(path: Path) -> Callable[[Any], float]:
    """Return a function that takes a number out of a message.

    :param path: where it stands
    :returns: a function from a message to the value, NaN where :func:`value_at` finds none
    """

    def get(message: Any) -> float:
        value = value_at(message, path)
        if value is None:
            return float("nan")
        return float(value.to_sec() if hasattr(value, "to_sec") else value)

    return get
