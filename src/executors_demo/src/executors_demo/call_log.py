# Pure: knows no ROS.
"""Log of the start, end and thread of calls."""

import itertools
import threading
import time
from contextlib import contextmanager
from typing import Callable, Dict, Iterator

from executors_demo.events import Event


class CallLog:
    """Log of the start and end of calls; thread-safe.

    :param say: writes a line
    :param now: returns the time [s]; log times are relative to the creation of this object
    """

    def __init__(self, say: Callable[[str], None], now: Callable[[], float] = time.monotonic):
        self._say = say
        self._now = now
        self._start = now()
        self._numbers: Dict[str, Iterator[int]] = {}
        self._lock = threading.Lock()

    @contextmanager
    def call(self, who: str, note: str = "") -> Iterator[None]:
        """Log the start of a call, and its end when the block is left.

        :param who: name of the callback, one word
        :param note: subject of the call
        """
        number = next(self._numbers.setdefault(who, itertools.count(1)))
        self._print_event(who, number, True, " ".join(note.split()))
        try:
            yield
        finally:
            self._print_event(who, number, False)

    def _print_event(self, who: str, number: int, begins: bool, note: str = "") -> None:
        thread = threading.current_thread().name
        with self._lock:  # keeps the lines in order of their times
            elapsed = self._now() - self._start
            self._say(str(Event(elapsed, thread, who, number, begins, note)))
