"""Wait for a condition on a page that replaces its elements meanwhile."""

import time
from typing import Callable, Optional, TypeVar

from selenium.common.exceptions import StaleElementReferenceException

from nodekit.testing.waiting import TIMEOUT_S

Value = TypeVar("Value")

#: First and longest pause before a condition is asked again [s]. A question to the page takes some
#: hundredths of a second of processor time, so these are longer than nodekit's.
_SHORTEST_S, _LONGEST_S = 0.02, 0.16


def wait_until(condition: Callable[[], Optional[Value]], what: Callable[[], object]) -> Value:
    """Poll until a condition holds, as :func:`nodekit.testing.waiting.wait_until` does.

    :param condition: polled until it returns a truthy value. An element that the
        page has replaced meanwhile only causes another poll.
    :param what: called only on failure, to describe the actual state
    :returns: the truthy answer
    :raises AssertionError: after a timeout
    """
    deadline, pause = time.monotonic() + TIMEOUT_S, _SHORTEST_S
    while True:
        try:
            answer = condition()
        except StaleElementReferenceException:
            answer = None
        if answer:
            return answer
        if time.monotonic() > deadline:
            raise AssertionError(f"after {TIMEOUT_S:g} s: {what()}")
        time.sleep(pause)
        pause = min(2.0 * pause, _LONGEST_S)
