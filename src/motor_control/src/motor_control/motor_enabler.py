"""Has a motor enabled by its service, in a thread of its own."""

import threading
import time
from typing import Callable, Tuple

import rospy
from std_msgs.msg import String

from motor_control.back_off import BackOff
from motor_control.enable_sequence import EnableSequence
from motor_control_msgs.srv import SetProcessBool, SetProcessBoolResponse
from nodekit import Node

#: Pauses between calls that fail: the first one and the longest, s.
_FIRST_PAUSE_S, _LONGEST_PAUSE_S = 0.2, 1.0
#: How often the connection to the motor is looked after, s.
_LOOK_EVERY_S = 0.2


def ask(service: Callable[[bool], SetProcessBoolResponse]) -> Tuple[bool, str]:
    """Ask for a motor to be enabled.

    :param service: what calls its EnableProcess
    :returns: whether it is enabled, and the answer; where there was none, the reason
    """
    try:
        answer = service(True)
    except Exception as error:  # a motor that dies meanwhile raises more than rospy documents
        return False, str(error) or type(error).__name__
    return answer.success, answer.message


class MotorEnabler:
    """Calls EnableProcess as often as needed, and says once a second what it waits for.

    A call waits for its answer without end, so no other thread makes one.

    :ROS Subscribers:
        - ``motor_state`` (std_msgs/String)

    :ROS Services called:
        - ``EnableProcess`` (motor_control_msgs/SetProcessBool)

    :param node: the node that wants the motor enabled
    """

    def __init__(self, node: Node) -> None:
        self._sequence = EnableSequence()
        self._group = node.group()
        self._news = threading.Event()
        self._back_off = BackOff(_FIRST_PAUSE_S, _LONGEST_PAUSE_S)
        self._next_call = 0.0
        self._waits_for = "its answer"
        self._was_connected = False
        self._closed = False
        self._service = rospy.ServiceProxy(node.resolve("EnableProcess"), SetProcessBool)
        self._subscription = node.subscribe(
            "motor_state", String, self._on_state, group=self._group
        )
        node.every(1.0, self._tell, steady=True, group=self._group)
        node.own(self)
        rospy.on_shutdown(self._news.set)
        threading.Thread(target=self._run, name="motor_enabler", daemon=True).start()

    def close(self) -> None:
        """Call no more."""
        self._closed = True
        self._news.set()

    @property
    def may_publish(self) -> bool:
        """Whether the motor was enabled for us and is still."""
        with self._group:
            return self._sequence.may_publish

    def _on_state(self, message: String) -> None:
        before = self._sequence.may_publish
        self._sequence.heard(message.data)
        after = self._sequence.may_publish
        self._next_call = 0.0
        self._back_off.reset()
        if before != after:
            rospy.loginfo("the motor is %s", message.data)
        self._news.set()

    def _run(self) -> None:
        while not (self._closed or rospy.is_shutdown()):
            self._notice_loss()
            now = time.monotonic()
            if self._wants_call() and now >= self._next_call:
                self._call()
            self._news.wait(_LOOK_EVERY_S)
            self._news.clear()

    def _wants_call(self) -> bool:
        with self._group:
            return self._sequence.wants_call

    def _notice_loss(self) -> None:
        connected = self._subscription.get_num_connections() > 0
        if self._was_connected and not connected:
            with self._group:
                self._sequence.lost()
            rospy.logwarn("the motor is gone")
        self._was_connected = connected

    def _call(self) -> None:
        self._waits_for = "its answer"
        success, message = ask(self._service)
        with self._group:
            self._sequence.answered(success)
            if success:
                self._back_off.reset()
            else:
                self._next_call = time.monotonic() + self._back_off.next()
        self._waits_for = message
        if success:
            rospy.loginfo("%s answers: %s", self._service.resolved_name, message)

    def _tell(self, _elapsed: float) -> None:
        if self._wants_call():
            rospy.loginfo("waiting for %s: %s", self._service.resolved_name, self._waits_for)
