"""Ctrl-C and SIGTERM, put off while a process is being started."""

import contextlib
import signal
import threading
from typing import Iterator, List


@contextlib.contextmanager
def interrupts_put_off() -> Iterator[None]:
    """Put Ctrl-C and SIGTERM off until the end: a process that is half started would stay behind.

    Only the main thread is interrupted by them.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: List[int] = []
    before = {
        number: signal.signal(number, lambda given, _frame: came.append(given))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    for given in came:
        signal.raise_signal(given)
