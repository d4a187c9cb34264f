"""Follow a parameter that nobody has declared, and that is never written."""

import copy
from typing import Any, Callable, Optional, Sequence

from nodekit.parameter_server.followers import Follower, call_listener
from nodekit.parameter_server.watcher import Watcher
from nodekit.parameters.kinds import MISSING, UNREADABLE, NoValue, is_same
from nodekit.parameters.reconciler import Seen

_UNKNOWN = NoValue("UNKNOWN")


class Following:
    """One key of the parameter server, followed from :func:`open_all` on.

    A value is kept when the master is restarted and has none.

    :param key: global name of a parameter or a namespace
    :param watcher: reads the server
    :param callback: called with each new raw value, None where there is none; must not
        block: other changes wait for it
    """

    def __init__(self, key: str, watcher: Watcher, callback: Callable[[Optional[Any]], object]):
        self.key = key.rstrip("/")
        self._watcher = watcher
        self._callback = callback
        self._follower = Follower(self.key, self._is_news, self._take)
        #: What the server held at last, and what of it the callback knows.
        self._held: Any = _UNKNOWN
        self._told: Any = _UNKNOWN

    def first(self) -> Optional[Any]:
        """Return the raw value now, None where there is none; the callback is told of others.

        :raises MasterUnreachable: if the master does not answer
        """
        self._held = self._watcher.first_reading(self.key)
        self._told = _value(self._held)
        return copy.deepcopy(self._told)

    def tell_again(self) -> None:
        """Have the callback told soon what there is, also where that is what it was told last.

        For those who learn of the value in a second way, and cannot tell which news is older.
        """
        self._told = _UNKNOWN
        self._watcher.tell([self._follower])

    def close(self) -> None:
        """Follow the key no longer."""
        self._watcher.close(self._follower)

    def _is_news(self, raw: Any) -> bool:
        return not is_same(raw, self._held)

    def _take(self, seen: Seen) -> bool:
        self._held = seen.raw
        value = _value(seen.raw)
        if not is_same(value, self._told) and not (seen.forgotten and seen.raw is MISSING):
            self._told = value
            call_listener(lambda: self._callback(copy.deepcopy(value)), self.key)
        return True


def open_all(followings: Sequence[Following]) -> None:
    """Follow keys from now on, in a few requests; no change since the first read is missed.

    :param followings: all with the same watcher
    :raises MasterUnreachable: if the master does not answer; nothing is followed then
    """
    if followings:
        followings[0]._watcher.open([one._follower for one in followings])


def _value(raw: Any) -> Optional[Any]:
    return None if raw is MISSING or raw is UNREADABLE else raw
