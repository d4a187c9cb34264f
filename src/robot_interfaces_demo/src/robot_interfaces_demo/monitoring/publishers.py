"""Publishers under one robot name: after a restart, or several at the same time."""

from typing import Dict, List

#: Most publishers kept.
_MOST = 8


class Publishers:
    """Publishers of messages with one robot name.

    After a restart a robot has a new publisher, and the old one is silent. Two publishers are
    rivals if their messages alternate.

    :ivar has_rivals: whether several are publishing now
    """

    def __init__(self) -> None:
        self.has_rivals = False
        self._current = ""
        self._heard_at: Dict[str, float] = {}

    def add_message(self, publisher: str, now: float, memory_s: float) -> None:
        """Record a message.

        :param publisher: name of the sending node
        :param now: time [s]
        :param memory_s: how long a silent publisher is kept [s]
        """
        if publisher != self._current:
            self.forget(now, memory_s)
            self._current = publisher
            if publisher in self._heard_at or len(self._heard_at) >= _MOST:
                self.has_rivals = True
            # Latest last: the first is removed when there are too many.
            self._heard_at.pop(publisher, None)
            if len(self._heard_at) >= _MOST:
                del self._heard_at[next(iter(self._heard_at))]
        self._heard_at[publisher] = now

    def forget(self, now: float, memory_s: float) -> None:
        """Remove silent publishers; a single remaining one has no rivals.

        :param now: time [s]
        :param memory_s: silence after which a publisher is removed [s]
        """
        if len(self._heard_at) > 1:
            self._heard_at = {
                name: heard_at
                for name, heard_at in self._heard_at.items()
                if now - heard_at <= memory_s or name == self._current
            }
            self.has_rivals = self.has_rivals and len(self._heard_at) > 1

    def names(self) -> List[str]:
        """Return the names of the publishers kept, sorted."""
        return sorted(self._heard_at)
