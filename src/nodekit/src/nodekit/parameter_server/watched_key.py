"""Watched key: one key of the parameter server watcher, with its unhandled notifications."""

from typing import Any, Callable, List, Tuple

import rospy

from nodekit.parameters.reconciler import Observation


class WatchedKey:
    """Key of the parameter server with a callback for unexpected values.

    :param key: global name of a parameter or a namespace
    :param is_news: returns whether a raw value differs from the expected one
    :param on_reading: called with the observation, in the watcher's thread; returns False
        to be called again after the next read, as if this call had not been made; raises
        MasterUnreachable to be called again later
    """

    def __init__(
        self, key: str, is_news: Callable[[Any], bool], on_reading: Callable[[Observation], bool]
    ) -> None:
        self.key = key
        self._is_news = is_news
        self._on_reading = on_reading
        self.reset()

    def reset(self) -> None:
        """Discard pending notifications and requests."""
        #: Pending notifications, oldest first.
        self.pushed: List[Tuple[str, Any]] = []
        #: Whether the callback has yet to learn that the master was restarted.
        self.forgotten = False
        #: Whether to pass the next value on, changed or not.
        self.due = False

    @property
    def is_due(self) -> bool:
        """Whether there is a reason to read the key."""
        return self.due or self.forgotten or bool(self.pushed)

    def is_news(self, raw: Any) -> bool:
        """Return whether to pass a raw value on."""
        return self.is_due or self._is_news(raw)

    def hand_over(self, raw: Any, read_at: float) -> bool:
        """Pass a value on; return whether the callback has accepted it.

        :param raw: value of the key, MISSING if it is not set
        :param read_at: start of the read on the monotonic clock [s]
        """
        pushed, is_done = self.pushed, False
        count = len(pushed)
        self.due = False  # before the call: a request during the call is kept
        try:
            is_done = self._on_reading(Observation(raw, pushed[:count], self.forgotten, read_at))
        finally:  # also after an exception
            self.due = self.due or not is_done
        if is_done:
            self.forgotten = False
            del pushed[:count]
        return is_done


def call_listener(listener: Callable[[], object], key: str) -> None:
    """Call a listener; its exception must not stop the others.

    :param listener: the function
    :param key: its key, for the log
    """
    try:
        listener()
    except (Exception, SystemExit):
        rospy.logerr("%s: a listener failed", key, exc_info=True)
