#!/usr/bin/env python3
"""Run a node with one of each resource, which echoes messages and publishes a last one."""

import time
from typing import Any

from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerResponse

from nodekit import FloatParameter, Node, ParameterSet, run


class Settings(ParameterSet):
    """Parameters of the node."""

    gain = FloatParameter(1.0, minimum=0.0, help="what is appended")


class Echo:
    """Echoes ``in`` on ``out``; publishes the number of its own messages on ``ticks``."""

    def __init__(self, node: Node) -> None:
        self.settings = node.declare_parameters(Settings)
        self.out = node.create_publisher("out", String, latch=True)
        self.ticks = node.create_publisher("ticks", String)
        node.create_subscription("in", String, self.answer)
        node.create_subscription(
            "out", String, lambda message: self.ticks.publish("own " + message.data)
        )
        node.create_service("~ask", Trigger, lambda _: TriggerResponse(True, self.gain))
        node.create_timer(50.0, lambda *_: self.ticks.publish("tick"))
        node.on_shutdown(self.take_leave)

    def take_leave(self) -> None:
        """Say the last word, and wait: a thread of rospy's sends it."""
        self.out.publish("farewell")
        time.sleep(1.0)

    @property
    def gain(self) -> str:
        """The gain in force, as text."""
        return str(self.settings.values.gain)

    def answer(self, message: Any) -> None:
        """Repeat a message, and add the gain."""
        self.out.publish(message.data + self.gain)


if __name__ == "__main__":
    run("echo", Echo)
