"""Timers that exclude each other, and a subscription in parallel."""

import threading
import time

import rospy
from std_msgs.msg import String

from nodekit import (
    FloatParameter,
    MultiThreadedExecutor,
    MutuallyExclusiveCallbackGroup,
    Node,
    ParameterSet,
    run,
)


def _period(default: float, what: str) -> FloatParameter:
    text = f"time between calls of {what}"
    return FloatParameter(default, minimum=0.001, maximum=3600.0, unit="s", help=text)


class AdvancedNodeParameters(ParameterSet):
    """Parameters of advanced_node."""

    timer1_period = _period(1.0, "timer1")
    timer2_period = _period(0.5, "timer2")
    timer1_sleep = FloatParameter(
        0.0, minimum=0.0, maximum=3600.0, unit="s", help="duration of the sleep in a call of timer1"
    )


class AdvancedNode:
    """Two timers in one exclusive group, and a subscription in another.

    While a timer works, the other timer waits, and messages are received.

    :ROS Subscribers:
        - ``input_topic`` (std_msgs/String)

    :ROS Parameters:
        - private, can be changed at run time: see :class:`AdvancedNodeParameters`
    """

    def __init__(self, node: Node) -> None:
        self._parameters = node.declare_parameters(AdvancedNodeParameters)
        MultiThreadedExecutor(2).add_node(node)
        timers, subscriptions = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()
        node.create_timer(
            lambda: 1.0 / self._parameters.values.timer1_period, self.timer1, group=timers
        )
        node.create_timer(
            lambda: 1.0 / self._parameters.values.timer2_period, self.timer2, group=timers
        )
        node.create_subscription("input_topic", String, self.on_input, group=subscriptions)

    def timer1(self, elapsed: float) -> None:
        """Work for ``~timer1_sleep``."""
        _log("timer1 begins")
        time.sleep(self._parameters.values.timer1_sleep)
        _log("timer1 ends")

    def timer2(self, elapsed: float) -> None:
        """Return immediately."""
        _log("timer2")

    def on_input(self, message: String) -> None:
        """Log the message."""
        _log(f"I heard: {message.data}")


def _log(text: str) -> None:
    rospy.loginfo("%s (%s)", text, threading.current_thread().name)


def main() -> None:
    """Run the node until it is shut down."""
    run("advanced_node", AdvancedNode)
