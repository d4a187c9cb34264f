"""First-order system node: a plant to control and to identify."""

import rospy
from std_msgs.msg import Float32

from first_order_sys_sim.sampled_plant import SampledPlant
from first_order_sys_sim.system_parameters import SystemParameters
from nodekit import Node, run

#: On a machine that is busy for up to this long, outputs are late, but not lost [s].
_CATCH_UP_S = 0.5


class FirstOrderSystem:
    """Publishes the output y of a first-order plant, tau dy/dt + y = K u.

    The input u is sampled every sample time and held; it is 0 before the first message. Each output
    is that at its nominal time, n / node rate after the first one.

    :ROS Subscribers:
        - ``input`` (std_msgs/Float32); a value that is not finite is ignored, with a warning

    :ROS Publishers:
        - ``output`` (std_msgs/Float32)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.SystemParameters`
    """

    def __init__(self, node: Node) -> None:
        self._settings = node.declare_parameters(SystemParameters, on_change=self._on_change)
        values = self._settings.values
        self._plant = SampledPlant(
            values.plant, values.system_sample_time, values.system_initial_conditions
        )
        # Nominal times of the last and of the next output, in the plant's time; by the clock, the
        # time at which the last one was published.
        self._due = self._next_due = 0.0
        self._published_at = 0.0
        self._publisher = node.create_publisher("output", Float32)
        node.create_subscription("input", Float32, self._on_input, finite=True)
        node.create_timer(
            lambda: self._settings.values.system_node_rate, self._publish, catch_up=_CATCH_UP_S
        )

    def _publish(self, elapsed: float) -> None:
        self._due = elapsed
        self._next_due = elapsed + 1.0 / self._settings.values.system_node_rate
        self._published_at = rospy.get_time()
        self._publisher.publish(Float32(self._plant.output(elapsed)))

    def _on_input(self, message: Float32) -> None:
        self._plant.set_input(self._now(), message.data)

    def _on_change(self, new: SystemParameters, old: SystemParameters) -> None:
        self._plant.change(self._now(), new.plant, new.system_sample_time)
        if new.system_initial_conditions != old.system_initial_conditions:
            self._plant.set_output(self._now(), new.system_initial_conditions)

    def _now(self) -> float:
        """Return the plant's time [s]: between the last output and the next one."""
        since = rospy.get_time() - self._published_at  # negative if the clock was set back
        return min(self._due + max(since, 0.0), self._next_due)


def main() -> None:
    """Run the node until it is shut down."""
    run("first_order_sys", FirstOrderSystem)
