"""Wait for a condition on a page that replaces its elements meanwhile."""

from typing import Callable, Optional, TypeVar

from selenium.common.exceptions import StaleElementReferenceException

from nodekit.testing import waiting

Value = TypeVar("Value")


def wait_until(condition: Callable[[], Optional[Value]], what: Callable[[], object]) -> Value:
    """Poll until a condition holds, as :func:`nodekit.testing.waiting.wait_until` does.

    :param condition: asked again and again; holds when its answer is truthy. An element that the
        page has replaced meanwhile only means to ask again.
    :param what: asked only on failure, for what is to be seen instead
    :returns: the truthy answer
    :raises AssertionError: when the time is over
    """

    def answer() -> Optional[Value]:
        try:
            return condition()
        except StaleElementReferenceException:
            return None

    return waiting.wait_until(answer, lambda: str(what()))
