"""A managed node whose heart beats only while it is active."""

import rospy

from nodekit import Maker, ManagedNode, Node, ParameterSet, StringParameter, run


class LifecycleAwareNodeParameters(ParameterSet):
    """Parameters of lifecycle_aware_node, which it has from configuring to cleanup."""

    robot_name = StringParameter("default_robot", help="the robot whose heartbeat it logs")


class LifecycleAwareNode(ManagedNode):
    """Logs a heartbeat each second while it is active, and each of its transitions.

    :ROS Publishers and Services:
        - those of every :class:`nodekit.ManagedNode`

    :ROS Parameters:
        - those of :class:`LifecycleAwareNodeParameters`, private; live once it is configured
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        rospy.loginfo("Node created (unconfigured)")

    def on_configure(self, made: Maker) -> None:
        """Read the parameters."""
        rospy.loginfo("Configuring...")
        self.settings = made.parameters(LifecycleAwareNodeParameters)
        rospy.loginfo("Configured for robot: %s", self.settings.values.robot_name)

    def on_activate(self, made: Maker) -> None:
        """Start the heartbeat."""
        rospy.loginfo("Activating...")
        made.every(1.0, self.beat)
        rospy.loginfo("Active and running")

    def on_deactivate(self) -> None:
        """Log it; the timer is stopped by itself."""
        rospy.loginfo("Deactivating...")
        rospy.loginfo("Deactivated")

    def on_cleanup(self) -> None:
        """Log it; the parameters are given up by themselves."""
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
