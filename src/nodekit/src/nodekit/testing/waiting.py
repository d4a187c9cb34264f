"""Wait for a condition instead of sleeping and hoping."""

import time
from typing import Callable, Optional, TypeVar

Value = TypeVar("Value")

#: Long enough for a loaded machine, s: a condition that holds is seen at once all the same.
TIMEOUT_S = 30.0


def wait_until(
    condition: Callable[[], Optional[Value]],
    what: Callable[[], str],
    timeout: float = TIMEOUT_S,
) -> Value:
    """Poll until the condition holds.

    :param condition: asked again and again; holds when its answer is truthy
    :param what: asked only on failure, for the text that says what was missing
    :param timeout: how long to wait at most, s
    :returns: the truthy answer
    :raises AssertionError: when the time is over
    """
    deadline = time.monotonic() + timeout
    while True:
        answer = condition()
        if answer:
            return answer
        if time.monotonic() > deadline:
            raise AssertionError(f"after {timeout:g} s: {what()}")
        time.sleep(0.05)
