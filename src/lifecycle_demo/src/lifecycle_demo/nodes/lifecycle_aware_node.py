"""Managed node with a heartbeat while it is active."""

import rospy

from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, ChangeStateRequest
from nodekit import (
    BoolParameter,
    CallFuture,
    ManagedNode,
    Node,
    NodeScope,
    ParameterSet,
    StringParameter,
    read_once,
    run,
)


class LifecycleAwareNodeParameters(ParameterSet):
    """Parameters of lifecycle_aware_node."""

    robot_name = StringParameter("default_robot", help="the robot whose heartbeat it logs")
    wait_for_manager = read_once(
        BoolParameter(
            False,
            help="wait for a manager to configure and activate it; otherwise it does so itself",
        )
    )


class LifecycleAwareNode(ManagedNode):
    """Logs a heartbeat each second while it is active, and each of its transitions.

    It configures and activates itself at the start, unless it is to wait for a manager.

    :ROS Publishers and Services:
        - see :class:`nodekit.ManagedNode`

    :ROS Parameters:
        - private, can be changed at run time: see :class:`LifecycleAwareNodeParameters`
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self.settings = node.declare_parameters(LifecycleAwareNodeParameters)
        rospy.loginfo("Node created (unconfigured)")
        if not self.settings.values.wait_for_manager:
            self._change_state = node.create_client("~change_state", ChangeState)
            self._start = node.create_timer(1.0, self._bring_up)

    def _bring_up(self, _elapsed: float) -> None:
        """Configure and activate once, as a manager would."""
        self._start.close()
        self._request("configure").add_done_callback(lambda _: self._request("activate"))

    def _request(self, label: str) -> CallFuture:
        return self._change_state.call_async(ChangeStateRequest(Transition(label=label)))

    def on_configure(self, scope: NodeScope) -> None:
        """Prepare for the robot in the parameters."""
        rospy.loginfo("Configuring...")
        rospy.loginfo("Configured for robot: %s", self.settings.values.robot_name)

    def on_activate(self, scope: NodeScope) -> None:
        """Start the heartbeat."""
        rospy.loginfo("Activating...")
        scope.create_timer(1.0, self.beat)
        rospy.loginfo("Active and running")

    def on_deactivate(self) -> None:
        """Log it; the timer is stopped automatically."""
        rospy.loginfo("Deactivating...")
        rospy.loginfo("Deactivated")

    def on_cleanup(self) -> None:
        """Log it; resources of :meth:`on_configure` are closed automatically."""
        rospy.loginfo("Cleaning up...")

    def on_shutdown(self) -> None:
        """Log it."""
        rospy.loginfo("Shutting down, was %s", self.previous_state.label)

    def beat(self, elapsed: float) -> None:
        """Log a heartbeat."""
        rospy.loginfo("%s: heartbeat", self.settings.values.robot_name)


def main() -> None:
    """Run the node until it is shut down."""
    run("lifecycle_aware_node", LifecycleAwareNode)
