"""The signal generator, a managed node and an action server, written with rclpy.

Their answers are the reference for those of the same ROS 1 nodes through the bridge.
"""

import math
import time
from typing import Any

import rclpy
from action_server2 import Server
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from basic_comms.msg import SignalMsg


class SignalGenerator(Node):
    """Publishes y = amplitude sin(frequency t)."""

    def __init__(self) -> None:
        super().__init__("signal_generator")
        self._declare("rate", 10.0, "samples published per second (Hz)", 0.1, 10_000.0)
        self._declare("amplitude", 2.0, "peak of the signal around its offset", 0.0, 1e9)
        self._signal = self.create_publisher(SignalMsg, "signal", 10)
        kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        status = self.create_publisher(String, "~/status", kept)
        status.publish(String(data="running 0.000"))
        self.create_service(SetBool, "~/enable", self._answer)
        self.create_service(Trigger, "~/reset", self._answer)
        self._start = time.monotonic()
        self.create_timer(0.1, self._publish)

    def _declare(self, name: str, value: float, text: str, low: float, high: float) -> None:
        limits = [FloatingPointRange(from_value=low, to_value=high)]
        descriptor = ParameterDescriptor(description=text, floating_point_range=limits)
        self.declare_parameter(name, value, descriptor)

    def _answer(self, _: Any, response: Any) -> Any:
        response.success, response.message = True, "time_x and phase start at 0 again"
        return response

    def _publish(self) -> None:
        now = time.monotonic() - self._start
        amplitude = self.get_parameter("amplitude").value
        message = SignalMsg(amplitude=amplitude, frequency=math.tau, time_x=now)
        message.signal_y = amplitude * math.sin(math.tau * now)
        self._signal.publish(message)


def main() -> None:
    """Run both until Ctrl-C."""
    rclpy.init()
    executor = SingleThreadedExecutor()
    executor.add_node(SignalGenerator())
    executor.add_node(LifecycleNode("managed"))
    robot = Node("robot")
    Server(robot, "/go_to")
    executor.add_node(robot)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


if __name__ == "__main__":
    main()
