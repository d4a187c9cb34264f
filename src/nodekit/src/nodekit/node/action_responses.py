# Pure: knows no ROS.
"""Responses of an action server's goal and cancel callbacks."""

import enum
from typing import Any


class GoalResponse(enum.IntEnum):
    """Response of a goal callback."""

    REJECT = 1
    ACCEPT = 2


class CancelResponse(enum.IntEnum):
    """Response of a cancel callback."""

    REJECT = 1
    ACCEPT = 2


def is_accepted(answer: Any, responses: Any) -> bool:
    """Return whether a callback has accepted.

    :param answer: result of the callback: a boolean, or one of the responses
    :param responses: GoalResponse or CancelResponse
    :raises TypeError: if it is neither
    """
    if isinstance(answer, bool):
        return answer
    if isinstance(answer, responses):
        return bool(answer is responses.ACCEPT)
    name = responses.__name__
    raise TypeError(f"returned {answer!r}: must be {name}.ACCEPT, {name}.REJECT or a boolean")
