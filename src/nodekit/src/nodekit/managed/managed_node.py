"""A node that waits for others to configure and activate it: ROS 2's lifecycle."""

from nodekit.lifecycle_states import (
    ACTIVATING,
    CLEANINGUP,
    CONFIGURING,
    DEACTIVATING,
    ERRORPROCESSING,
    SHUTTINGDOWN,
    State,
)
from nodekit.managed.lifecycle import Result
from nodekit.managed.lifecycle_services import LifecycleServices
from nodekit.node.node import Node
from nodekit.node.node_scope import NodeScope


class ManagedNode:
    """What the class of a managed node derives from; each callback may be left out.

    A callback returns None or True where it has succeeded, False where it has not: then the state
    stays what it was. What it raises is logged, and :meth:`on_error` is called. All are called one
    at a time, in the node's default group.

    :ROS Publishers:
        - ``~transition_event`` (lifecycle_msgs/TransitionEvent): each step
        - ``~state`` (lifecycle_msgs/State): latched
        - ``~heartbeat`` (std_msgs/Header): at 5 Hz in any state, for a manager

    :ROS Services:
        - ``~change_state`` (lifecycle_msgs/ChangeState)
        - ``~get_state`` (lifecycle_msgs/GetState)
        - ``~get_available_states`` (lifecycle_msgs/GetAvailableStates)
        - ``~get_available_transitions``, ``~get_transition_graph``
          (lifecycle_msgs/GetAvailableTransitions)

    :param node: the node
    """

    def __init__(self, node: Node) -> None:
        self.node = node
        self._managed = LifecycleServices(
            node,
            {
                CONFIGURING: self.on_configure,
                ACTIVATING: self.on_activate,
                DEACTIVATING: self.on_deactivate,
                CLEANINGUP: self.on_cleanup,
                SHUTTINGDOWN: self.on_shutdown,
                ERRORPROCESSING: self.on_error,
            },
        )

    @property
    def state(self) -> State:
        """The present state, with its ``id`` and ``label``."""
        return self._managed.state

    @property
    def previous_state(self) -> State:
        """The state before the latest transition, which may be under way."""
        return self._managed.lifecycle.previous

    def on_configure(self, made: NodeScope) -> Result:
        """Get ready.

        :param made: makes what lives until cleanup. It is opened when this has succeeded, and
            publishes and ticks only while the node is active
        """

    def on_activate(self, made: NodeScope) -> Result:
        """Begin to work.

        :param made: makes what lives until the node is active no longer; opened as above
        """

    def on_deactivate(self) -> Result:
        """Stop working; a last message may still be published."""

    def on_cleanup(self) -> Result:
        """Give up what :meth:`on_configure` got, besides what it has made."""

    def on_shutdown(self) -> Result:
        """Get ready for the end, which comes from any state."""

    def on_error(self) -> Result:
        """Tidy up after a callback that failed with an error: then all can begin anew.

        Where this fails too, the node is finalized.
        """
