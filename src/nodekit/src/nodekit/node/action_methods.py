"""Methods of NodeScope for actions; their modules are imported when an action is created."""

import importlib
from typing import Any, Callable, Optional

from nodekit.groups.callback_groups import CallbackGroup


class ActionMethods:
    """Methods of :class:`.NodeScope` that create servers and clients of actions."""

    def create_action_server(
        self,
        name: str,
        action_class: type,
        execute_callback: Optional[Callable[[Any], Any]] = None,
        goal_callback: Optional[Callable[[Any], Any]] = None,
        handle_accepted_callback: Optional[Callable[[Any], Any]] = None,
        cancel_callback: Optional[Callable[[Any], Any]] = None,
        newest_only: bool = False,
        group: Optional[CallbackGroup] = None,
    ) -> Any:
        """Serve an action, by actionlib's protocol.

        When the node ends or a managed node is deactivated, all goals are cancelled; those that
        have not ended within 0.5 s are aborted. While a managed node is not active, goals are
        aborted on arrival.

        :param name: name of the action
        :param action_class: action class, such as ``FibonacciAction``
        :param execute_callback: called with each goal's handle, in its own thread and in no
            group; returns the result. The goal is aborted if the callback raises an exception, or
            returns without having ended it
        :param goal_callback: called with each goal's message; returns whether it is accepted, or
            raises :exc:`.GoalRejected` with a reason. By default, all are accepted
        :param handle_accepted_callback: called with an accepted goal's handle, which the node then
            ends in other callbacks, instead of a call of ``execute_callback``
        :param cancel_callback: called with the handle of a goal that a client wants to end; returns
            whether that is accepted. By default, it always is
        :param newest_only: whether an accepted goal replaces earlier ones: they are cancelled, and
            a new execute callback is called once the one before has returned
        :param group: group of all these but ``execute_callback``; the node's default group by
            default
        :returns: the :class:`.ActionServer`
        :raises TypeError: if there is neither an execute nor a handle accepted callback
        """
        scope: Any = self
        resolved = scope.resolve(name)
        return _module("action_server").ActionServer(
            scope,
            resolved,
            _module("action_types").messages_of(action_class, resolved),
            group or scope.default_group,
            execute_callback,
            goal_callback,
            handle_accepted_callback,
            cancel_callback,
            newest_only,
        )

    def create_action_client(
        self, name: str, action_class: type, group: Optional[CallbackGroup] = None
    ) -> Any:
        """Return a client of an action, by actionlib's protocol.

        :param name: name of the action
        :param action_class: action class, such as ``FibonacciAction``
        :param group: group of feedback and done callbacks; the node's default group by default
        :returns: the :class:`.ActionClient`
        """
        scope: Any = self
        resolved = scope.resolve(name)
        messages = _module("action_types").messages_of(action_class, resolved)
        return _module("action_client").ActionClient(
            scope, resolved, messages, group or scope.default_group
        )

    def _is_active(self) -> bool:
        """Return whether servers take goals."""
        return True


def _module(name: str) -> Any:
    """Import a module at its first use: it takes 6 ms, and few nodes have actions."""
    return importlib.import_module(f"nodekit.node.{name}")
