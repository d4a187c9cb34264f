"""Simulated motor node: first-order plant with ``motor_input`` (voltage) and ``motor_output``."""

import time

import rospy

from first_order_sys_sim.sampled_plant import SampledPlant
from nodekit import Node, run
from pid_control.course_names import adopt_course_names
from pid_control.msg import motor_input, motor_output
from pid_control.plant.delayed_plant import DelayedPlant
from pid_control.plant.status import NOT_TURNING, status_of
from pid_control.plant.system_parameters import SystemParameters

#: Longest delay after which late outputs are still published, as on a busy machine [s].
_CATCH_UP_S = 0.5


class System:
    """Simulated motor with speed y, T dy/dt + y = K u, a dead zone and a greatest speed.

    The input u arrives after a dead time, is sampled every sample time and held; it is 0 before the
    first message. Each output is computed for the time at which it was due; ``time`` is that time
    since the node's start. At shutdown the node publishes a last output with speed 0.

    :ROS Subscribers:
        - ``motor_input`` (pid_control/motor_input); values that are not finite are dropped, with a
          warning

    :ROS Publishers:
        - ``motor_output`` (pid_control/motor_output)

    :ROS Parameters:
        - those of :class:`.SystemParameters`, private and live; see :func:`.adopt_course_names`
    """

    def __init__(self, node: Node) -> None:
        adopt_course_names(node, SystemParameters)
        self._settings = node.declare_parameters(SystemParameters, on_change=self._on_change)
        values = self._settings.values
        sampled = SampledPlant(values.plant, values.system_sample_time, values.system_initial_cond)
        self._plant = DelayedPlant(sampled, values.system_dead_time)
        # Outputs follow /clock if it is published.
        self._clock = time.monotonic if rospy.rostime.is_wallclock() else rospy.get_time
        # Due times of the last and of the next output in the motor's time, and the clock's time at
        # which the last one was published.
        self._due = self._next_due = 0.0
        self._published_at = 0.0
        self._has_ended = False
        self._group = node.default_group
        self._publisher = node.create_publisher("motor_output", motor_output)
        node.create_subscription("motor_input", motor_input, self._on_input, finite=True)
        node.create_timer(
            lambda: self._settings.values.system_node_rate, self._publish, catch_up=_CATCH_UP_S
        )
        node.on_shutdown(self._end)

    def _publish(self, elapsed: float) -> None:
        if self._has_ended:
            return
        values = self._settings.values
        self._due, self._next_due = elapsed, elapsed + 1.0 / values.system_node_rate
        self._published_at = self._clock()
        message = motor_output()  # assigned below: half the time of the constructor with arguments
        message.output = speed = self._plant.output(elapsed)
        message.time, message.status = elapsed, status_of(speed, values.system_max_speed)
        self._publisher.publish(message)

    def _on_input(self, message: motor_input) -> None:
        self._plant.set_input(self._now(), message.input)

    def _on_change(self, new: SystemParameters, old: SystemParameters) -> None:
        now = self._now()
        self._plant.change(now, new.plant, new.system_sample_time, new.system_dead_time)
        if new.system_initial_cond != old.system_initial_cond:
            self._plant.set_output(now, new.system_initial_cond)

    def _end(self) -> None:
        with self._group:  # so that no output in progress is sent after the last one
            self._has_ended = True
            self._publisher.publish(motor_output(0.0, self._due, NOT_TURNING))

    def _now(self) -> float:
        """Return the motor's time [s], between the last output and the next one."""
        since = self._clock() - self._published_at  # below 0 if the clock was set back
        return min(self._due + max(since, 0.0), self._next_due)


def main() -> None:
    """Run the node until it is shut down."""
    run("system", System)
