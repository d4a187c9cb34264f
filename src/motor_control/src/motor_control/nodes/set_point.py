"""Set point node: publishes the input of a motor once it is enabled."""

import copy
from typing import Any

import rospy
from std_msgs.msg import Float32

from basic_comms.signals.run_control import RUNNING, RunControl
from basic_comms.signals.signal_parameters import SignalParameters
from basic_comms.signals.signal_source import SignalSource
from motor_control.motor_enabler import MotorEnabler
from nodekit import Node, run


def _with_default(name: str, default: float) -> Any:
    """Return a signal's parameter with another default, for a declaration under another name."""
    parameter = copy.copy(SignalParameters.declared[name])
    parameter.default = default
    return parameter


class SetPointParameters(SignalParameters):
    """Parameters of a signal, with ``omega`` in place of ``frequency``."""

    omega = _with_default("frequency", 1.0)
    #: Read by the signal source; not a parameter here.
    frequency: Any = property(lambda self: self.omega)
    #: The motor decides when the signal starts.
    autostart: Any = property(lambda self: False)


class SetPoint:
    """Publishes the input of a motor, by default u = amplitude sin(omega t).

    It enables the motor first, and publishes nothing before. When the motor is disabled or lost, it
    publishes stop_value once, and the signal's time is held until the motor is enabled again. It
    also publishes stop_value when it ends or, if it is managed, is deactivated, because a motor
    holds its last input.

    :ROS Publishers:
        - ``motor_input_u`` (std_msgs/Float32)

    :ROS Subscribers and Services called:
        - see :class:`.MotorEnabler`

    :ROS Parameters:
        - private, can be changed at run time: see :class:`.SetPointParameters`
    """

    def __init__(self, node: Node) -> None:
        self._settings = node.declare_parameters(SetPointParameters, on_change=self._on_change)
        self._source = SignalSource()
        self._run_control = RunControl(enabled=False)
        #: Whether to stop the motor, and whether the set point has ended.
        self._has_to_stop = self._has_ended = False
        self._group = node.default_group
        self._publisher = node.create_publisher("motor_input_u", Float32)
        self._motor = MotorEnabler(node)
        node.create_timer(lambda: self._settings.values.rate, self._publish)
        node.before_deactivate(self._stop)
        node.on_shutdown(self._end)
        self._warn_of_aliasing(self._settings.values)

    def _on_change(self, new: SetPointParameters, _old: SetPointParameters) -> None:
        self._warn_of_aliasing(new)

    def _publish(self, elapsed: float) -> None:
        if self._has_ended:
            return
        settings = self._settings.values
        runs = self._motor.may_publish
        self._run_control.enable(elapsed, runs)
        if not runs:
            self._stop()
            return
        self._has_to_stop = True
        status = self._run_control.at(elapsed, settings.start_delay, settings.duration)
        value = settings.stop_value
        if status.state == RUNNING:
            value = self._source.sample(status.time_x, settings).value
        self._publisher.publish(Float32(value))

    def _stop(self) -> None:
        with self._group:
            if self._has_to_stop:
                self._has_to_stop = False
                self._publisher.publish(Float32(self._settings.values.stop_value))

    def _end(self) -> None:
        with self._group:  # so that no input follows the stop value
            self._has_ended = True
            self._stop()

    def _warn_of_aliasing(self, settings: SetPointParameters) -> None:
        if settings.aliasing:
            rospy.logwarn("%s: %s", self._publisher.resolved_name, settings.aliasing)


def main() -> None:
    """Run the node until it is shut down."""
    run("set_point", SetPoint)
