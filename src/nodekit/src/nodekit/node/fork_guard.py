"""Guard of callbacks that fork: a child process ends with the callback.

Otherwise the child would continue in its parent's place, with the parent's connections: read the
parent's messages, publish in its name, or wait for threads that the child does not have.
"""

import os
import traceback
from typing import Any, Callable, NoReturn, Optional

from nodekit.entry_point import end_at_once
from nodekit.process_context import PROCESS


def call(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a user's function; in a child forked by it, do not return.

    :param function: the function
    :param arguments: its arguments
    :returns: its result
    :raises BaseException: its exception
    """
    forks = PROCESS.forks
    try:
        result = function(*arguments)
    except BaseException as error:
        if forks != PROCESS.forks:
            _end_child(error)
        raise
    if forks != PROCESS.forks:
        _end_child()
    return result


def _end_child(error: Optional[BaseException] = None) -> NoReturn:
    """End this process without calling its parent's exit handlers.

    :param error: exception of the function: a SystemExit sets the status; any other is printed,
        and the status is 1
    """
    if isinstance(error, SystemExit):
        end_at_once(error.code)
    if error is not None:
        traceback.print_exception(type(error), error, error.__traceback__)
    end_at_once(int(error is not None))


def _count_fork() -> None:
    PROCESS.forks += 1


os.register_at_fork(after_in_child=_count_fork)
