"""The least that takes one topic from ROS 1 to ROS 2: bare rospy and rclpy in one process.

The bytes of a signal_msg are the same in both, so that nothing is converted.
"""

import contextlib
from typing import Any

from ros2_bridge.environment import start


def main() -> None:
    """Take over each message of /hop0."""
    import rclpy
    import rospy
    from rclpy.executors import ExternalShutdownException

    from basic_comms.msg import SignalMsg

    rospy.init_node("bare", disable_signals=True)
    rclpy.init()
    node = rclpy.create_node("bare")
    out = node.create_publisher(SignalMsg, "/hop0", 1000)

    def forward(message: Any) -> None:
        out.publish(b"\0\1\0\0" + message._buff)  # CDR has a head: little endian

    rospy.Subscriber("/hop0", rospy.AnyMsg, forward, tcp_nodelay=True)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    start.main("bare")
