"""Tell a node's class of parameters, in its callback group."""

from typing import Any, Callable

from nodekit.groups.groups import Group
from nodekit.node.callbacks import Bell
from nodekit.parameter_server.following import Following
from nodekit.parameter_server.live_parameters import LiveParameters
from nodekit.parameter_server.watcher import Watcher


class Change(Bell):
    """Tells of changes of declared parameters, from what was told last to what is in force now.

    :param group: the callback's group
    :param live: the parameters
    :param on_change: called with the new and the old values
    """

    kind = "on_change"

    def __init__(
        self, group: Group, live: LiveParameters[Any], on_change: Callable[[Any, Any], Any]
    ) -> None:
        super().__init__(group, self._tell, f"{live.namespace}: on_change")
        self._live, self._on_change = live, on_change
        self._told = live.values

    def start(self) -> None:
        """Tell of changes from now on, and of one that has been."""
        self._live.add_listener(self.ring)
        self.ring()

    def _tell(self) -> None:
        old, self._told = self._told, self._live.values
        if self._told != old:
            self._on_change(self._told, old)


class Followed(Bell):
    """Tells of a parameter that nobody has declared: at the start, and when it changes.

    :param group: the callback's group
    :param key: global name
    :param watcher: reads the server
    :param callback: called with the value, None where it is not set
    """

    kind = "follow"

    def __init__(
        self, group: Group, key: str, watcher: Watcher, callback: Callable[[Any], Any]
    ) -> None:
        super().__init__(group, lambda: callback(self._value), key)
        #: What is to be opened before the first ring.
        self.following = Following(key, watcher, self._take)
        self._value = self.following.first()

    def start(self) -> None:
        """Tell of the value there is; to be called when :attr:`following` was opened."""
        self.ring()

    def close(self) -> None:
        """Tell of nothing any more."""
        super().close()
        self.following.close()

    def _take(self, value: Any) -> None:
        self._value = value
        self.ring()
