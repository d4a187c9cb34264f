# Pure: knows no ROS.
"""Answers of the callbacks of an action's server."""

import enum
from typing import Any


class GoalResponse(enum.IntEnum):
    """Answer of a goal callback."""

    REJECT = 1
    ACCEPT = 2


class CancelResponse(enum.IntEnum):
    """Answer of a cancel callback."""

    REJECT = 1
    ACCEPT = 2


def is_accepted(answer: Any, responses: Any) -> bool:
    """Return whether a callback has accepted.

    :param answer: its result: a boolean, or one of the responses
    :param responses: GoalResponse or CancelResponse
    :raises TypeError: if it is neither
    """
    if isinstance(answer, bool):
        return answer
    if isinstance(answer, responses):
        return bool(answer is responses.ACCEPT)
    name = responses.__name__
    raise TypeError(f"returned {answer!r}: must be {name}.ACCEPT, {name}.REJECT or a boolean")
