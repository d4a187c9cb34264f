"""Node that is controlled by its parameters, and logs their changes."""

import rospy

from nodekit import BoolParameter, FloatParameter, Node, ParameterSet, StringParameter, run, rule


class ConfigurableNodeParameters(ParameterSet):
    """Parameters of configurable_node."""

    update_rate = FloatParameter(10.0, maximum=1000.0, unit="Hz", help="Publishing rate in Hz")
    robot_name = StringParameter("humanoid_01", help="Name of the robot")
    enabled = BoolParameter(True, help="Enable/disable processing")

    @rule("update_rate")
    def positive(self) -> None:
        """Reject invalid rates with the course's message; less than once a day counts as 0.

        A range in the declaration would also do, and other programs could read it.
        """
        if self.update_rate < 1e-5:
            raise ValueError("update_rate must be positive")


class ConfigurableNode:
    """Logs a tick at a rate while it is enabled, and each change of its parameters.

    :ROS Parameters:
        - private, can be changed at run time: see :class:`ConfigurableNodeParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(
            ConfigurableNodeParameters, on_change=self._on_change
        )
        self._log = node.create_rate_limited_log()
        settings = self._parameters.values
        rospy.loginfo("Started: robot=%s, rate=%sHz", settings.robot_name, settings.update_rate)
        node.create_timer(lambda: self._parameters.values.update_rate, self.tick)

    def tick(self, elapsed: float) -> None:
        """Log a tick, if it is enabled."""
        settings = self._parameters.values
        if settings.enabled:
            self._log.line(f"{settings.robot_name}: tick at {settings.update_rate}Hz")

    def _on_change(self, new: ConfigurableNodeParameters, old: ConfigurableNodeParameters) -> None:
        before = old.as_dict()
        for name, value in new.as_dict().items():
            if value != before[name]:
                rospy.loginfo("Parameter changed: %s = %s", name, value)


def main() -> None:
    """Run the node until it is shut down."""
    run("configurable_node", ConfigurableNode)
