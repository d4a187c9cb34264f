"""The controller: has the motor do what the set point says."""

import time
from typing import Optional

import rospy

from nodekit import Node, Throttle, run
from pid_control.controller.controller_parameters import ControllerParameters
from pid_control.controller.pid import Pid
from pid_control.controller.stamps import FIRST, GAP, LATE, RESTART, StampClassifier
from pid_control.msg import motor_input, motor_output, set_point
from pid_control_msgs.msg import ControllerTerms

#: How often it looks whether the motor is silent, Hz.
_CHECKS_HZ = 20.0
#: Least time between two warnings of one kind, s.
_WARN_EVERY_S = 10.0


class Controller:
    """Answers each output of a motor with an input: P, PI or PID, see :class:`.Pid`.

    The time between two outputs is that of their stamps, see :class:`.StampClassifier`; the input
    carries the stamp of the output that it answers. Where the motor is started anew, or a few
    outputs are missing, the next input goes on from the last one.

    The motor is stopped, by one input of 0, while there is no set point yet or the controller is
    not enabled, when nothing was heard of the motor for longer than the time-out, and when the node
    ends or, where it is managed, is deactivated. After that the controller begins anew.

    :ROS Subscribers:
        - ``set_point`` (pid_control/set_point), ``motor_output`` (pid_control/motor_output); what
          is not finite is left out, with a warning

    :ROS Publishers:
        - ``motor_input`` (pid_control/motor_input)
        - ``~terms`` (pid_control_msgs/ControllerTerms): what each input is made of

    :ROS Parameters:
        - those of :class:`.ControllerParameters`, private and live
    """

    def __init__(self, node: Node) -> None:
        self._settings = node.declare_parameters(ControllerParameters, on_change=self._on_change)
        self._pid = Pid(self._settings.values.pid)
        self._stamps = StampClassifier()
        self._set_point: Optional[float] = None
        self._is_stopped = self._has_ended = False
        #: Whether outputs are answered: from the timer's first tick on, as it ticks while active.
        self._is_active = False
        # By ROS time: a simulation that stands still is not silence.
        self._clock = time.monotonic if rospy.rostime.is_wallclock() else rospy.get_time
        #: The motor's latest stamp, the latest input, and when the motor was heard last, s.
        self._stamp = self._input = self._heard_at = 0.0
        self._publisher = node.create_publisher("motor_input", motor_input)
        self._terms = node.create_publisher("~terms", ControllerTerms)
        self._motor = node.resolve("motor_output")
        self._throttle = Throttle(_WARN_EVERY_S)
        self._group = node.default_group
        node.create_subscription("set_point", set_point, self._on_set_point, finite=True)
        node.create_subscription("motor_output", motor_output, self._on_output, finite=True)
        node.create_timer(_CHECKS_HZ, self._check_silence)
        node.before_deactivate(self._pause)
        node.on_shutdown(self._end)

    def _on_set_point(self, message: set_point) -> None:
        self._set_point = message.setPoint

    def _on_output(self, message: motor_output) -> None:
        if not self._is_active:
            return
        settings = self._settings.values
        stamp = self._stamps.classify(message.time, settings.timeout)
        if stamp.kind == LATE:
            self._warn(f"a sample of {message.time:g} s came late or twice, and is left out")
            return
        self._stamp, self._heard_at = message.time, self._clock()
        if self._set_point is None or not settings.enabled:
            self._stop()
            return
        if self._is_stopped or stamp.kind == FIRST:
            self._is_stopped = False
            self._pid.reset()
        elif stamp.kind == RESTART:
            rospy.logwarn("%s: the motor was started anew", self._motor)
            self._pid.resume(self._input)
        elif stamp.kind == GAP:
            self._warn(f"no sample for more than {settings.timeout:g} s before {message.time:g} s")
            self._pid.resume(self._input)
        terms = self._pid.update(self._set_point, message.output, stamp.interval)
        self._input = terms.output
        answer = motor_input()  # filled in afterwards, which takes genpy half the time
        answer.input, answer.time = terms.output, message.time
        self._publisher.publish(answer)
        if self._terms.get_num_connections() > 0:
            error = self._set_point - message.output
            self._terms.publish(ControllerTerms(message.time, error, *terms))

    def _on_change(self, new: ControllerParameters, _old: ControllerParameters) -> None:
        self._pid.change(new.pid)

    def _check_silence(self, _elapsed: float) -> None:
        self._is_active = not self._has_ended
        timeout = self._settings.values.timeout
        if not self._is_stopped and self._clock() - self._heard_at > timeout:
            was_at_work = self._input != 0.0
            self._stop()
            self._stamps = StampClassifier()  # the next motor may be another one
            if was_at_work:
                rospy.logwarn("%s: nothing for %g s: the input is 0", self._motor, timeout)

    def _stop(self) -> None:
        if not self._is_stopped:
            self._is_stopped = True
            self._input = 0.0
            self._publisher.publish(0.0, self._stamp)

    def _pause(self) -> None:
        with self._group:  # or an output that is answered just now would have the last word
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
