"""Read-only subscription to any key of the parameter server: a callback gets each change."""

import copy
from typing import Any, Callable, Optional, Sequence

from nodekit.argument_checks import check_function
from nodekit.parameter_server.watched_key import WatchedKey, call_listener
from nodekit.parameter_server.watcher import Watcher, get_watcher
from nodekit.parameters.parameter_types import MISSING, UNREADABLE, NoValue, is_same
from nodekit.parameters.reconciler import Observation

_UNKNOWN = NoValue("UNKNOWN")


class FollowedParameter:
    """Undeclared parameter or namespace, followed from :func:`open_all` on.

    The value is kept when the master is restarted and has no value.

    :param key: global name of a parameter or a namespace
    :param watcher: the process's watcher
    :param callback: called with each new raw value, None if unset; must not
        block: other changes wait for it
    :raises TypeError: if the callback is not a function, or async
    """

    def __init__(self, key: str, watcher: Watcher, callback: Callable[[Optional[Any]], object]):
        check_function(callback, key, 1)
        self.key = key.rstrip("/")
        self._watcher = watcher
        self._callback = callback
        self._watched = WatchedKey(self.key, self._is_news, self._on_reading)
        #: The server's last value, and the last value that the callback got.
        self._held: Any = _UNKNOWN
        self._reported: Any = _UNKNOWN

    def first(self) -> Optional[Any]:
        """Return the raw value now, None if unset; the callback gets later values.

        :raises MasterUnreachable: if the master does not answer
        """
        self._held = self._watcher.first_reading(self.key)
        self._reported = _value(self._held)
        return copy.deepcopy(self._reported)

    def report_again(self) -> None:
        """Call the callback soon with the current value, also if it is unchanged.

        For callers that also get the value from elsewhere, and do not know which is older.
        """
        self._reported = _UNKNOWN
        self._watcher.request_report([self._watched])

    def close(self) -> None:
        """Stop following the key."""
        self._watcher.close(self._watched)

    def _is_news(self, raw: Any) -> bool:
        return not is_same(raw, self._held)

    def _on_reading(self, seen: Observation) -> bool:
        self._held = seen.raw
        value = _value(seen.raw)
        if not is_same(value, self._reported) and not (seen.forgotten and seen.raw is MISSING):
            self._reported = value
            call_listener(lambda: self._callback(copy.deepcopy(value)), self.key)
        return True


def open_all(followed: Sequence[FollowedParameter]) -> None:
    """Follow keys from now on, in few requests; no change since the first read is missed.

    :param followed: followed parameters with the same watcher
    :raises MasterUnreachable: if the master does not answer; nothing is followed then
    """
    if followed:
        followed[0]._watcher.open([one._watched for one in followed])


def follow_parameter(key: str, callback: Callable[[Optional[Any]], object]) -> FollowedParameter:
    """Follow a key from now on without a node's class, in an initialised node.

    :param key: global name of a parameter or a namespace
    :param callback: called with each raw value, the current one first, None if unset;
        must not block: other changes wait for it
    :returns: the followed parameter, which the caller closes at the end
    :raises MasterUnreachable: if the master does not answer
    """
    followed = FollowedParameter(key, get_watcher(), callback)
    open_all([followed])
    return followed


def _value(raw: Any) -> Optional[Any]:
    return None if raw is MISSING or raw is UNREADABLE else raw
