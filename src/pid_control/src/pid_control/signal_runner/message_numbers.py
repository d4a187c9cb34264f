# Pure: knows no ROS.
"""Numbers in a message, by the names of their fields."""

from typing import Any, Dict

#: Most elements of an array that are read, and deepest level of messages in messages.
_MOST, _DEEPEST = 8, 3


def numbers_in(message: Any, prefix: str = "", depth: int = 0) -> Dict[str, float]:
    """Return the numbers of a message, without times, headers and texts.

    :param message: a ROS message
    :param prefix: names of the enclosing fields
    :param depth: number of enclosing messages
    """
    found: Dict[str, float] = {}
    for name in getattr(message, "__slots__", ()):
        if name in ("header", "layout"):
            continue
        value = getattr(message, name)
        if isinstance(value, (list, tuple)):
            for index, one in enumerate(value[:_MOST]):
                if _is_number(one):
                    found[f"{prefix}{name}[{index}]"] = float(one)
        elif _is_number(value):
            found[prefix + name] = float(value)
        elif not hasattr(value, "to_sec") and depth < _DEEPEST:  # not a time
            found.update(numbers_in(value, f"{prefix}{name}/", depth + 1))
    return found


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
