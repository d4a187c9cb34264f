"""A key of the parameter server that somebody watches, and what they have not been told of yet."""

from typing import Any, Callable, List, Tuple

import rospy

from nodekit.parameters.reconciler import Observation


class WatchedKey:
    """A key, and who is told when something else stands there than expected.

    :param key: global name of a parameter or a namespace
    :param is_news: tells whether a raw value is another one than expected
    :param on_reading: called with what was seen, in the thread of the watcher; returns False
        to be called again after the next read, as if this call had not been; raises
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
        """Begin anew, as the key is watched from now on."""
        #: Notifications that are not handed over yet, oldest first.
        self.pushed: List[Tuple[str, Any]] = []
        #: Whether it is still to be handed over that the master was restarted.
        self.forgotten = False
        #: Whether to hand over whatever is read.
        self.due = False

    @property
    def is_due(self) -> bool:
        """Whether there is a reason to read the key."""
        return self.due or self.forgotten or bool(self.pushed)

    def is_news(self, raw: Any) -> bool:
        """Tell whether a raw value that was read is to be handed over."""
        return self.is_due or self._is_news(raw)

    def hand_over(self, raw: Any, read_at: float) -> bool:
        """Hand over what was read; return whether that is done.

        :param raw: value of the key, MISSING where nothing is set
        :param read_at: start of the read, s on the monotonic clock
        """
        pushed, is_done = self.pushed, False
        count = len(pushed)
        self.due = False  # before: what is asked for meanwhile is handed over once more
        try:
            is_done = self._on_reading(Observation(raw, pushed[:count], self.forgotten, read_at))
        finally:  # also where this raises
            self.due = self.due or not is_done
        if is_done:
            self.forgotten = False
            del pushed[:count]
        return is_done


def call_listener(listener: Callable[[], object], key: str) -> None:
    """Call a function of somebody else's, whose defects must keep nobody else from being told.

    :param listener: the function
    :param key: what it listens to
    """
    try:
        listener()
    except (Exception, SystemExit):
        rospy.logerr("%s: a listener failed", key, exc_info=True)
