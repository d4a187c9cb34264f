"""Ctrl-C, SIGTERM and the end of the terminal: they end a command, but not while processes start or
end.
"""

import contextlib
import signal
import sys
import threading
from typing import Iterator, List


def exit_on_signals() -> None:
    """Have SIGTERM and SIGHUP raise SystemExit, as Ctrl-C raises KeyboardInterrupt.

    By default they end a process at once, and leave behind what it has started.
    """
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:  # or nohup would be of no use
            signal.signal(number, lambda given, _frame: sys.exit(128 + given))


@contextlib.contextmanager
def deferred_signals() -> Iterator[None]:
    """Put Ctrl-C, SIGTERM and SIGHUP off until the end.

    A process that is half started, or half ended, would stay behind. Only the main thread is
    interrupted by them.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: List[int] = []
    before = {
        number: signal.signal(number, lambda given, _frame: came.append(given))
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for given in came:  # also after an exception, which may have come of them
            signal.raise_signal(given)
