"""Call back when parameters have changed, in a callback group."""

from typing import Any, Callable

from nodekit.groups.callback_groups import CallbackGroup
from nodekit.node.callbacks import CoalescingCallback
from nodekit.parameter_server.followed_parameter import FollowedParameter
from nodekit.parameter_server.live_parameters import LiveParameters
from nodekit.parameter_server.watcher import Watcher
from nodekit.validation import check_function


class ChangeCallback(CoalescingCallback):
    """Called with changes of declared parameters, from what it knows to what is in force now.

    :param group: the callback's group
    :param live: the parameters
    :param on_change: called with the new and the old values
    """

    kind = "on_change"

    def __init__(
        self, group: CallbackGroup, live: LiveParameters[Any], on_change: Callable[[Any, Any], Any]
    ) -> None:
        super().__init__(group, self._report_change, f"{live.namespace}: on_change")
        check_function(on_change, self.what)
        self._live, self._on_change = live, on_change
        self._reported = live.values

    def start(self) -> None:
        """Call back for changes from now on, and for one that has been."""
        self._live.add_listener(self.ring)
        self.ring()

    def _report_change(self) -> None:
        old, self._reported = self._reported, self._live.values
        if self._reported != old:
            self._on_change(self._reported, old)


class ParameterCallback(CoalescingCallback):
    """Called with a parameter that nobody has declared: at the start, and when it changes.

    :param group: the callback's group
    :param key: global name
    :param watcher: reads the server
    :param callback: called with the value, None where it is not set
    """

    kind = "follow"

    def __init__(
        self, group: CallbackGroup, key: str, watcher: Watcher, callback: Callable[[Any], Any]
    ) -> None:
        super().__init__(group, lambda: callback(self._value), key)
        check_function(callback, key)
        #: What is to be opened before the first ring.
        self.followed = FollowedParameter(key, watcher, self._on_value)
        self._value = self.followed.first()

    def start(self) -> None:
        """Call back with the value there is; to be called when :attr:`followed` was opened."""
        self.ring()

    def close(self) -> None:
        """Call back no more."""
        super().close()
        self.followed.close()

    def _on_value(self, value: Any) -> None:
        self._value = value
        self.ring()
