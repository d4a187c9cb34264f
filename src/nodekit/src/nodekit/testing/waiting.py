"""Waiting for conditions in tests, instead of sleeping."""

import threading
import time
from typing import Any, Callable, Optional, TypeVar

Value = TypeVar("Value")

#: Default time-out [s]: a hang guard, which a busy machine does not reach.
TIMEOUT_S = 100.0
#: First and longest pause between two polls [s]: short waits end early, long ones poll rarely.
_SHORTEST_S, _LONGEST_S = 0.001, 0.05


def wait_until(
    condition: Callable[[], Optional[Value]],
    what: Callable[[], str],
    timeout: float = TIMEOUT_S,
) -> Value:
    """Poll until the condition holds.

    :param condition: called repeatedly, until its result is truthy
    :param what: called on failure; returns a description of what was missing
    :param timeout: longest wait [s]
    :returns: the truthy result
    :raises AssertionError: after the time-out
    """
    deadline, pause = time.monotonic() + timeout, _SHORTEST_S
    while True:
        answer = condition()
        if answer:
            return answer
        if time.monotonic() > deadline:
            raise AssertionError(f"after {timeout:g} s: {what()}")
        time.sleep(pause)
        pause = min(2.0 * pause, _LONGEST_S)


def in_thread(function: Callable[..., Any], *arguments: Any) -> threading.Thread:
    """Call a function in a daemon thread.

    :param function: the function
    :param arguments: its arguments
    :returns: the started thread
    """
    thread = threading.Thread(target=function, args=arguments, daemon=True)
    thread.start()
    return thread
