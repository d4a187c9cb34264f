"""Worker threads for calls that may block, outside the web thread."""

import threading
from typing import Any, Callable, Hashable, Set

#: Most concurrent jobs, including jobs that never end.
LIMIT = 64


class Worker:
    """Runner of jobs, each in a separate thread, without waiting for them.

    rospy waits forever for a stopped node. So each subject has one job at a time, and a job that
    never ends does not block others.

    :param deliver: runs a function in the web thread
    """

    def __init__(self, deliver: Callable[[Callable[[], None]], None]) -> None:
        self._deliver = deliver
        self._busy: Set[Hashable] = set()

    def is_busy(self, subject: Hashable) -> bool:
        """Return whether a job for a subject is still running."""
        return subject in self._busy

    def run(self, subject: Hashable, work: Callable[[], Any], then: Callable[[Any], None]) -> bool:
        """Start a job; call this from the web thread.

        :param subject: the subject of the job
        :param work: the job; returns or raises its result
        :param then: called in the web thread with the result, or the exception
        :returns: False if an earlier job for the subject is running, so this one was not started
        """
        if subject in self._busy or len(self._busy) >= LIMIT:
            return False
        self._busy.add(subject)

        def finish(result: Any) -> None:
            self._busy.discard(subject)
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
