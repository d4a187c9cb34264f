"""Worker threads for calls that may block, outside the web thread."""

import threading
from typing import Any, Callable, Hashable, Set

#: Most pieces of work at a time, those that wait for ever included.
LIMIT = 64


class Worker:
    """Runs each job in a thread of its own, without waiting for it.

    A node that is stopped answers never, and rospy waits for it as long. So one piece of work for
    the same thing is done at a time, and a job that never ends blocks no other.

    :param deliver: hands a function to the web thread
    """

    def __init__(self, deliver: Callable[[Callable[[], None]], None]) -> None:
        self._deliver = deliver
        self._busy: Set[Hashable] = set()

    def is_busy(self, what: Hashable) -> bool:
        """Return whether a job for a subject is still running."""
        return what in self._busy

    def run(self, what: Hashable, work: Callable[[], Any], then: Callable[[Any], None]) -> bool:
        """Start a job; call this from the web thread.

        :param what: the thing that it is about
        :param work: the work; returns or raises its result
        :param then: called in the web thread with the result, or the exception
        :returns: False if earlier work is not done yet, so that this was not begun
        """
        if what in self._busy or len(self._busy) >= LIMIT:
            return False
        self._busy.add(what)

        def finish(result: Any) -> None:
            self._busy.discard(what)
            then(result)

        def body() -> None:
            result: Any
            try:
                result = work()
            except Exception as error:
                result = error
            self._deliver(lambda: finish(result))

        threading.Thread(target=body, name="background", daemon=True).start()
        return True
