"""The motor: its input is a voltage, its output a speed."""

import time

import rospy

from first_order_sys_sim.sampled_plant import SampledPlant
from nodekit import Node, run
from pid_control.course_names import adopt_course_names
from pid_control.msg import motor_input, motor_output
from pid_control.plant.delayed_plant import DelayedPlant
from pid_control.plant.status import NOT_TURNING, status_of
from pid_control.plant.system_parameters import SystemParameters

#: A machine that is busy for up to this long makes outputs late, but loses none, s.
_CATCH_UP_S = 0.5


class System:
    """Publishes the speed y of a motor, T dy/dt + y = K u, with a dead zone and a greatest speed.

    The input u arrives after a dead time, is sampled every sample time and held; it is 0 before the
    first message. Each output is that of the moment it was due, and ``time`` is that moment,
    counted from the node's start. At the node's end a last output tells that the motor stands.

    :ROS Subscribers:
        - ``motor_input`` (pid_control/motor_input); what is not finite is left out, with a warning

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
        # Outputs are due by /clock where there is one.
        self._clock = time.monotonic if rospy.rostime.is_wallclock() else rospy.get_time
        # In the motor's time, when the last output was due and the next one is; by the clock, when
        # the last one went out.
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
        message = motor_output()  # filled in afterwards, which takes genpy half the time
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
        with self._group:  # or an output that is due just now would have the last word
            self._has_ended = True
            self._publisher.publish(motor_output(0.0, self._due, NOT_TURNING))

    def _now(self) -> float:
        """Return the motor's time, s: from the last output on, until the next one is due."""
        since = self._clock() - self._published_at  # below 0 where the clock was set back
        return min(self._due + max(since, 0.0), self._next_due)


def main() -> None:
    """Run the node until it is shut down."""
    run("system", System)
