"""Wait for a condition instead of sleeping and hoping; have a thread do what has to wait."""

import threading
import time
from typing import Any, Callable, Optional, TypeVar

Value = TypeVar("Value")

#: Long enough for a loaded machine, s: a condition that holds is seen at once all the same.
TIMEOUT_S = 30.0
#: First and longest pause before it is asked again, s: what holds at once is seen at once, and what
#: takes long is not slowed down by the questions.
_SHORTEST_S, _LONGEST_S = 0.001, 0.05


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
    """Call a function in a thread of its own, which does not keep the process from ending.

    :param function: what to call
    :param arguments: what to call it with
    :returns: the thread, which has been started
    """
    thread = threading.Thread(target=function, args=arguments, daemon=True)
    thread.start()
    return thread
