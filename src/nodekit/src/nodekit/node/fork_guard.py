"""End a process that was forked in a callback, when the callback has ended.

Otherwise it would go on where its parent does, with that one's connections: read what others send
to the parent, publish in its name, or wait for threads that it has not got.
"""

import contextlib
import os
import sys
import traceback
from typing import Any, Callable, NoReturn, Optional

#: How often this process was forked off since its program was begun.
_count = 0


def call(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a user's function; in a child that is forked meanwhile, this does not return.

    :param function: the function
    :param arguments: what to call it with
    :returns: what it returns
    :raises BaseException: what it raises
    """
    count = _count
    try:
        result = function(*arguments)
    except BaseException as error:
        if count != _count:
            _end_child(error)
        raise
    if count != _count:
        _end_child()
    return result


def _end_child(error: Optional[BaseException] = None) -> NoReturn:
    """End this process, and nothing of its parent's: no handler of the end is called.

    :param error: what the function has raised: the status is that of a SystemExit, and 1 of any
        other exception, which is printed
    """
    status = 0
    if isinstance(error, SystemExit):
        status = error.code if isinstance(error.code, int) else int(error.code is not None)
    elif error is not None:
        status = 1
        traceback.print_exception(type(error), error, error.__traceback__)
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(Exception):  # closed, or none
            stream.flush()
    os._exit(status & 0xFF)


def _count_on() -> None:
    global _count
    _count += 1


os.register_at_fork(after_in_child=_count_on)
