"""Set something up that may fail, and try again."""

from typing import Callable


class SetupFailed(Exception):
    """What was tried again and again, and failed each time; the text says why."""


def set_up(attempt: Callable[[], None], recover: Callable[[Exception], None], attempts: int) -> int:
    """Try until it succeeds, and recover after each failure but the last.

    :param attempt: what may fail
    :param recover: called with what it raised, before it is tried again
    :param attempts: how often to try at most; at least 1
    :returns: how often it was tried
    :raises SetupFailed: if it failed each time
    """
    for number in range(1, attempts + 1):
        try:
            attempt()
            return number
        except Exception as error:  # of any kind: hardware fails in many ways
            if number == attempts:
                raise SetupFailed(f"failed {attempts} times, the last time: {error}") from error
            recover(error)
    raise ValueError(f"attempts: refused {attempts}: must be a whole number from 1 on")
