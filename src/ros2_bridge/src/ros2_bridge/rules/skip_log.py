"""Log of what is not bridged: each reason once, at most one line per second."""

import contextlib
import threading
from typing import Iterator, List, Optional, Set

#: Shortest time between two lines [s].
_PAUSE_S = 1.0
#: Most reasons in a line; more follow in the next.
_MOST = 5


class Unbridgeable(Exception):
    """Something that cannot be bridged; the text names it and the reason."""


class SkipLog:
    """Log of reasons, joined into lines; thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._reported: Set[str] = set()
        #: Reasons reported in the current poll and in the previous one.
        self._polls: List[Set[str]] = [set(), set()]
        self._pending: List[str] = []
        self._last: Optional[float] = None

    def report(self, reason: str) -> None:
        """Log a reason, unless it was reported before.

        :param reason: what is not bridged, and why
        """
        with self._lock:
            self._polls[0].add(reason)
            if reason not in self._reported:
                self._reported.add(reason)
                self._pending.append(reason)

    @contextlib.contextmanager
    def catching(self, name: str) -> Iterator[None]:
        """Report any exception, so that everything else is still bridged.

        :param name: of a topic, service or node
        """
        try:
            yield
        except Unbridgeable as reason:
            self.report(str(reason))
        except Exception as error:
            # Some of rclpy's messages mark the position in the name on further lines.
            why = (str(error) or repr(error)).partition("\n")[0].rstrip(":")
            self.report(f"{name}: {why}")

    def end_poll(self) -> None:
        """End a poll of both graphs, during which each valid reason was reported."""
        with self._lock:
            self._polls = [set(), self._polls[0]]

    def current(self) -> List[str]:
        """Return the reasons of the current and the previous poll, sorted."""
        with self._lock:
            return sorted(self._polls[0] | self._polls[1])

    def next_line(self, now: float) -> Optional[str]:
        """Return a line for the log; None if there is nothing to log, or it is too early.

        :param now: monotonic time [s]
        """
        with self._lock:
            if not self._pending or (self._last is not None and now < self._last + _PAUSE_S):
                return None
            part, self._pending = self._pending[:_MOST], self._pending[_MOST:]
            self._last = now
        return f"not bridged: {'; '.join(part)}"
