"""Queue of messages to or from a board: keeps only the newest of a topic that falls behind."""

import threading
import time
from collections import OrderedDict, deque
from typing import Any, Deque, Optional

#: Values of one stream that may wait, so that a burst is sent completely. With one more, the line
#: has fallen behind, and only the newest value matters.
DEPTH = 16
#: Most messages kept in total; more are a defect of their sender.
MOST_KEPT = 1000


class MessageQueue:
    """Message queue with many writers and one reader.

    Reliable messages, such as service calls, come first and in order. Of each stream the newest
    values follow; if too many wait, all but the newest are dropped and counted. Streams alternate.

    :param depth: number of values of one stream that may wait
    """

    def __init__(self, depth: int = DEPTH) -> None:
        self._depth = depth
        self._lock = threading.Lock()
        #: Held while the queue is empty. A bare lock wakes a thread in half the time of a condition
        #: variable.
        self._empty = threading.Lock()
        self._empty.acquire()
        self._kept: Deque[Any] = deque()
        self._streams: "OrderedDict[Any, Deque[Any]]" = OrderedDict()
        self._is_closed = self._is_idle = False
        self._dropped = self._refused = 0

    @property
    def dropped(self) -> int:
        """Number of stream values that were dropped for newer ones."""
        return self._dropped

    @property
    def refused(self) -> int:
        """Number of messages rejected because the queue was full."""
        return self._refused

    @property
    def is_idle(self) -> bool:
        """Whether the reader waits for a message, so it has handled all earlier ones."""
        return self._is_idle

    def put(self, stream: Any, message: Any, depth: int = 0) -> None:
        """Add a value of a stream.

        :param stream: key of the stream
        :param message: the value
        :param depth: number of its values that may wait; 0 for the default
        """
        with self._lock:
            waiting = self._streams.setdefault(stream, deque())
            if len(waiting) >= (depth or self._depth):
                self._dropped += len(waiting)
                waiting.clear()
            waiting.append(message)
            self._notify()

    def put_reliable(self, message: Any) -> bool:
        """Add a message that must not be lost.

        :param message: the message
        :returns: whether it was accepted; False while :data:`MOST_KEPT` wait
        """
        with self._lock:
            if len(self._kept) >= MOST_KEPT:
                self._refused += 1
                return False
            self._kept.append(message)
            self._notify()
            return True

    def get(self, timeout: float) -> Optional[Any]:
        """Take out the next message.

        :param timeout: longest wait [s]
        :returns: None after the timeout, or if the queue is closed
        """
        self.wait(timeout)
        with self._lock:
            return self._next()

    def wait(self, timeout: float) -> bool:
        """Wait for a message without removing it; a newer one may still replace it.

        :param timeout: longest wait [s]
        :returns: whether a message is available, or the queue is closed
        """
        end = time.monotonic() + timeout
        while True:
            with self._lock:
                if self._kept or self._streams or self._is_closed:
                    return True
                self._is_idle = True
            left = end - time.monotonic()
            if left <= 0.0 or not self._empty.acquire(timeout=left):
                self._is_idle = False
                return False

    def clear(self) -> None:
        """Drop all waiting messages without counting them: their receiver is gone."""
        with self._lock:
            self._kept.clear()
            self._streams.clear()

    def close(self) -> None:
        """End all waits."""
        with self._lock:
            self._is_closed = True
            self._notify()

    def _next(self) -> Optional[Any]:
        if self._kept:
            return self._kept.popleft()
        if not self._streams:
            return None
        stream, waiting = self._streams.popitem(last=False)
        message = waiting.popleft()
        if waiting:
            self._streams[stream] = waiting  # behind the others
        return message

    def _notify(self) -> None:
        self._is_idle = False
        if self._empty.locked():
            self._empty.release()
