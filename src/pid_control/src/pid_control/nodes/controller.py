"""The controller node: drives the motor to the set point."""

import time
from typing import Optional

import rospy

from nodekit import Node, Throttle, run
from pid_control.controller.controller_parameters import ControllerParameters
from pid_control.controller.pid import Pid
from pid_control.controller.stamps import FIRST, GAP, LATE, RESTART, StampClassifier
from pid_control.msg import motor_input, motor_output, set_point
from pid_control_msgs.msg import ControllerTerms

#: Rate of the check for a silent motor [Hz].
_CHECKS_HZ = 20.0
#: Shortest time between two warnings [s].
_WARN_EVERY_S = 10.0


class Controller:
    """P, PI or PID controller that answers each motor output with an input; see :class:`.Pid`.

    The interval between two outputs is computed from their stamps, see :class:`.StampClassifier`;
    each input carries the stamp of its output. If the motor restarts, or a few outputs are missing,
    the next input continues from the last one.

    The controller stops the motor with one input of 0 while the set point is missing, or older than
    the command timeout, or the controller is disabled; when the motor is silent for longer than the
    timeout; and when the node shuts down or, if managed, is deactivated. After that the controller
    is reset.

    :ROS Subscribers:
        - ``set_point`` (pid_control/set_point), ``motor_output`` (pid_control/motor_output); values
          that are not finite are dropped, with a warning

    :ROS Publishers:
        - ``motor_input`` (pid_control/motor_input)
        - ``~terms`` (pid_control_msgs/ControllerTerms): the terms of each input

    :ROS Parameters:
        - those of :class:`.ControllerParameters`, private and live
    """

    def __init__(self, node: Node) -> None:
        self._settings = node.declare_parameters(ControllerParameters, on_change=self._on_change)
        self._pid = Pid(self._settings.values.pid)
        self._stamps = StampClassifier()
        self._set_point: Optional[float] = None
        self._is_stopped = self._has_ended = False
        #: Outputs are answered from the timer's first tick on: it ticks only while active.
        self._is_active = False
        # ROS time: a paused simulation is not a silent motor.
        self._clock = time.monotonic if rospy.rostime.is_wallclock() else rospy.get_time
        #: Latest stamp of the motor [s], latest input, and times of the latest output and set point
        #: received [s].
        self._stamp = self._input = self._heard_at = self._asked_at = 0.0
        self._publisher = node.create_publisher("motor_input", motor_input)
        self._terms = node.create_publisher("~terms", ControllerTerms)
        self._motor, self._command = node.resolve("motor_output"), node.resolve("set_point")
        self._throttle = Throttle(_WARN_EVERY_S)
        self._group = node.default_group
        node.create_subscription("set_point", set_point, self._on_set_point, finite=True)
        node.create_subscription("motor_output", motor_output, self._on_output, finite=True)
        node.create_timer(_CHECKS_HZ, self._check_silence)
        node.before_deactivate(self._pause)
        node.on_shutdown(self._end)

    def _on_set_point(self, message: set_point) -> None:
        self._set_point, self._asked_at = message.setPoint, self._clock()

    def _on_output(self, message: motor_output) -> None:
        if not self._is_active:
            return
        settings = self._settings.values
        stamp = self._stamps.classify(message.time, settings.timeout)
        if stamp.kind == LATE:
            self._warn(f"sample dropped: late or repeated ({message.time:g} s)")
            return
        self._stamp, self._heard_at = message.time, self._clock()
        if self._set_point is None or not settings.enabled:
            self._stop()
            return
        if self._is_stopped or stamp.kind == FIRST:
            self._is_stopped = False
            self._pid.reset()
        elif stamp.kind == RESTART:
            rospy.logwarn("%s: the motor was restarted", self._motor)
            self._pid.resume(self._input)
        elif stamp.kind == GAP:
            self._warn(f"no sample for more than {settings.timeout:g} s before {message.time:g} s")
            self._pid.resume(self._input)
        terms = self._pid.update(self._set_point, message.output, stamp.interval)
        self._input = terms.output
        answer = (
            motor_input()
        )  # assigned below: half the time of genpy's constructor with arguments
        answer.input, answer.time = terms.output, message.time
        self._publisher.publish(answer)
        if self._terms.get_num_connections() > 0:
            error = self._set_point - message.output
            self._terms.publish(ControllerTerms(message.time, error, *terms))

    def _on_change(self, new: ControllerParameters, _old: ControllerParameters) -> None:
        self._pid.change(new.pid)

    def _check_silence(self, _elapsed: float) -> None:
        self._is_active = not self._has_ended
        self._forget_old_set_point()
        timeout = self._settings.values.timeout
        if not self._is_stopped and self._clock() - self._heard_at > timeout:
            self._stop()
            self._stamps = StampClassifier()  # the next motor may have another clock
            if self._input != 0.0:
                rospy.logwarn("%s: nothing for %g s: the input is 0", self._motor, timeout)

    def _forget_old_set_point(self) -> None:
        longest = self._settings.values.command_timeout
        is_old = self._set_point is not None and self._clock() - self._asked_at > longest > 0.0
        if is_old:
            self._set_point = None
            if not self._is_stopped:
                rospy.logwarn("%s: nothing for %g s: the input is 0", self._command, longest)
                self._stop()

    def _stop(self) -> None:
        if not self._is_stopped:
            self._is_stopped = True
            self._publisher.publish(0.0, self._stamp)

    def _pause(self) -> None:
        with self._group:  # so that no answer in progress is sent after the 0
            if self._is_active:
                self._is_active = False
                self._stop()
                self._stamps = StampClassifier()

    def _end(self) -> None:
        with self._group:
            self._has_ended = True
            self._pause()

    def _warn(self, text: str) -> None:
        if self._throttle.is_due():
            rospy.logwarn("%s: %s", self._motor, text)


def main() -> None:
    """Run the node until it is shut down."""
    run("controller", Controller)
