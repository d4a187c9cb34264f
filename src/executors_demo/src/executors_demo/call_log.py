# Pure: knows no ROS.
"""Says which call runs when, and in which thread."""

import itertools
import threading
import time
from contextlib import contextmanager
from typing import Callable, Dict, Iterator

from executors_demo.events import Event


class CallLog:
    """Says when calls begin and end; any thread may use it.

    :param say: takes a line
    :param now: returns the time, s; what is said counts from now on
    """

    def __init__(self, say: Callable[[str], None], now: Callable[[], float] = time.monotonic):
        self._say = say
        self._now = now
        self._start = now()
        self._numbers: Dict[str, Iterator[int]] = {}
        self._lock = threading.Lock()

    @contextmanager
    def call(self, who: str, note: str = "") -> Iterator[None]:
        """Say that a call begins, and when the block is left, that it ends.

        :param who: what is called; one word
        :param note: what the call is about
        """
        number = next(self._numbers.setdefault(who, itertools.count(1)))
        self._print_event(who, number, True, " ".join(note.split()))
        try:
            yield
        finally:
            self._print_event(who, number, False)

    def _print_event(self, who: str, number: int, begins: bool, note: str = "") -> None:
        thread = threading.current_thread().name
        with self._lock:  # so that the lines come in the order of their times
            elapsed = self._now() - self._start
            self._say(str(Event(elapsed, thread, who, number, begins, note)))
