"""Termination signals of a command, deferred while processes start or end."""

import contextlib
import signal
import sys
import threading
from typing import Iterator, List


def exit_on_signals() -> None:
    """Make SIGTERM and SIGHUP raise SystemExit, as Ctrl-C raises KeyboardInterrupt.

    Their default action ends the process immediately, without its child processes.
    """
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:  # keep nohup working
            signal.signal(number, lambda given, _frame: sys.exit(128 + given))


@contextlib.contextmanager
def deferred_signals() -> Iterator[None]:
    """Defer SIGINT, SIGTERM and SIGHUP until the end of the block.

    A signal while a process starts or ends would leave it running. In other threads this does
    nothing: signals interrupt only the main thread.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    received: List[int] = []
    before = {
        number: signal.signal(number, lambda given, _frame: received.append(given))
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for given in received:  # also after an exception, which the signal may have caused
            signal.raise_signal(given)
