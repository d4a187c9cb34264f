"""Wait for a condition instead of sleeping and hoping."""

import time
from typing import Callable, Optional, TypeVar

from selenium.common.exceptions import StaleElementReferenceException

Value = TypeVar("Value")

#: Long enough for a loaded machine, s: a condition that holds is seen at once all the same.
TIMEOUT = 30.0


def wait_until(condition: Callable[[], Optional[Value]], what: Callable[[], object]) -> Value:
    """Poll until a condition holds.

    :param condition: asked again and again; holds when its answer is truthy. An element that the
        page has replaced meanwhile only means to ask again.
    :param what: asked only on failure, for what is to be seen instead
    :returns: the truthy answer
    :raises AssertionError: when the time is over
    """
    deadline = time.monotonic() + TIMEOUT
    while True:
        try:
            answer = condition()
        except StaleElementReferenceException:
            answer = None
        if answer:
            return answer
        if time.monotonic() > deadline:
            raise AssertionError(f"after {TIMEOUT:g} s: {what()}")
        time.sleep(0.05)
