"""Callbacks for parameter changes: of declared parameters, or of one undeclared parameter."""

from typing import Any, Callable

from nodekit.argument_checks import check_function
from nodekit.groups.callback_groups import CallbackGroup
from nodekit.node.callbacks import CoalescingCallback
from nodekit.parameter_server.followed_parameter import FollowedParameter
from nodekit.parameter_server.live_parameters import LiveParameters
from nodekit.parameter_server.watcher import Watcher


class ChangeCallback(CoalescingCallback):
    """Callback for changes of declared parameters, from the last reported values to the current.

    :param group: the callback's group
    :param live: the parameters
    :param on_change: called with the new and the old values
    """

    kind = "on_change"

    def __init__(
        self, group: CallbackGroup, live: LiveParameters[Any], on_change: Callable[[Any, Any], Any]
    ) -> None:
        super().__init__(group, self._report_change, f"{live.namespace}: on_change")
        check_function(on_change, self.what, 2)
        self._live, self._on_change = live, on_change
        self._reported = live.values

    def start(self) -> None:
        """Report changes from now on, and one that has happened before."""
        self._live.add_listener(self.trigger)
        self.trigger()

    def _report_change(self) -> None:
        old, self._reported = self._reported, self._live.values
        if self._reported != old:
            self._on_change(self._reported, old)


class ParameterCallback(CoalescingCallback):
    """Callback for an undeclared parameter: at the start, and when it changes.

    :param group: the callback's group
    :param key: global name
    :param watcher: polls the parameter server
    :param callback: called with the value, None if it is not set
    """

    kind = "follow"

    def __init__(
        self, group: CallbackGroup, key: str, watcher: Watcher, callback: Callable[[Any], Any]
    ) -> None:
        super().__init__(group, lambda: callback(self._value), key)
        check_function(callback, key, 1)
        #: To be opened before the first trigger.
        self.followed = FollowedParameter(key, watcher, self._on_value)
        self._value = self.followed.first()

    def start(self) -> None:
        """Report the current value; call this once :attr:`followed` is open."""
        self.trigger()

    def close(self) -> None:
        """Start no new calls, and stop following the parameter."""
        super().close()
        self.followed.close()

    def _on_value(self, value: Any) -> None:
        self._value = value
        self.trigger()
