"""Client of EnableProcess that enables a motor."""

import time
from typing import Optional

import rospy
from std_msgs.msg import String

from motor_control.enable_sequence import EnableSequence
from motor_control_msgs.srv import SetProcessBool, SetProcessBoolRequest
from nodekit import CallError, CallFuture, MutuallyExclusiveCallbackGroup, Node

#: Pauses after failed calls: the first, and the maximum; they double [s].
_FIRST_PAUSE_S, _LONGEST_PAUSE_S = 0.2, 1.0
#: Rate of checking whether the motor is connected, and whether to call [Hz].
_CHECK_HZ = 5.0
#: Timeout for the motor's answer [s].
_ANSWER_S = 5.0


class MotorEnabler:
    """Calls EnableProcess until the motor is enabled; logs once a second while waiting.

    :ROS Subscribers:
        - ``motor_state`` (std_msgs/String)

    :ROS Services called:
        - ``EnableProcess`` (motor_control_msgs/SetProcessBool)

    :param node: the node that needs the motor
    """

    def __init__(self, node: Node) -> None:
        self._sequence = EnableSequence()
        self._pause = _FIRST_PAUSE_S
        self._next_call = 0.0
        self._call: Optional[CallFuture] = None
        self._reason = "no answer yet"
        self._was_connected = False
        self._group = MutuallyExclusiveCallbackGroup()
        self._motor = node.create_client("EnableProcess", SetProcessBool, group=self._group)
        self._subscription = node.create_subscription(
            "motor_state", String, self._on_state, group=self._group
        )
        node.create_timer(_CHECK_HZ, self._check_connection, steady=True, group=self._group)
        node.create_timer(1.0, self._log_waiting, steady=True, group=self._group)

    @property
    def may_publish(self) -> bool:
        """Whether the motor was enabled for us and still is."""
        with self._group:
            return self._sequence.may_publish

    def _on_state(self, message: String) -> None:
        before = self._sequence.may_publish
        self._sequence.heard(message.data)
        if self._sequence.may_publish != before:
            rospy.loginfo("the motor is %s", message.data)
        self._next_call = 0.0
        self._pause = _FIRST_PAUSE_S
        self._call_if_wanted()

    def _check_connection(self, _elapsed: float) -> None:
        connected = self._subscription.get_num_connections() > 0
        if self._was_connected and not connected:
            self._sequence.lost()
            rospy.logwarn("the motor is gone")
        self._was_connected = connected
        self._call_if_wanted()

    def _call_if_wanted(self) -> None:
        wants = self._sequence.wants_call and time.monotonic() >= self._next_call
        if wants and self._call is None:
            self._call = self._motor.call_async(SetProcessBoolRequest(True), _ANSWER_S)
            self._call.add_done_callback(self._on_answer)

    def _on_answer(self, call: CallFuture) -> None:
        self._call = None
        try:
            answer = call.result()
            success, self._reason = answer.success, answer.message
        except CallError as error:
            success, self._reason = False, str(error)
        self._sequence.answered(success)
        if success:
            self._pause = _FIRST_PAUSE_S
            rospy.loginfo("%s answers: %s", self._motor.name, self._reason)
        else:
            self._next_call = time.monotonic() + self._pause
            self._pause = min(2.0 * self._pause, _LONGEST_PAUSE_S)

    def _log_waiting(self, _elapsed: float) -> None:
        if self._sequence.wants_call:
            rospy.loginfo("waiting for the motor: %s", self._reason)
