"""Base class of managed nodes, which others configure and activate: ROS 2's lifecycle."""

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
from nodekit.node.ros_node import Node
from nodekit.node.node_scope import NodeScope


class ManagedNode:
    """Base class of managed nodes; each callback is optional.

    A callback returns None or True on success, False on failure: the state then stays as it was.
    An exception is logged, and :meth:`on_error` is called. Callbacks run one at a time, in the
    node's default group.

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
        """The state before the latest transition, which may be running."""
        return self._managed.lifecycle.previous

    def on_configure(self, scope: NodeScope) -> Result:
        """Prepare the node.

        :param scope: creates resources that last until cleanup; they are opened when this has
            succeeded, and publish and tick only while the node is active
        """

    def on_activate(self, scope: NodeScope) -> Result:
        """Start to work.

        :param scope: creates resources that last until deactivation; opened as above
        """

    def on_deactivate(self) -> Result:
        """Stop working; a last message may still be published."""

    def on_cleanup(self) -> Result:
        """Release resources of :meth:`on_configure` that its scope does not own."""

    def on_shutdown(self) -> Result:
        """Prepare for the end, from any state."""

    def on_error(self) -> Result:
        """Clean up after a callback that ended with an error; the node is unconfigured then.

        If this fails too, the node is finalized.
        """
