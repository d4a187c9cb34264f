"""The process node as one would write it with rclpy: scaled and lifted."""

import contextlib

import rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import Float32


def main() -> None:
    """Answer each sample until interrupted."""
    rclpy.init()
    node = rclpy.create_node("process")
    publisher = node.create_publisher(Float32, "proc_signal", 10)

    def answer(message: Float32) -> None:
        output = Float32()
        output.data = 0.5 * message.data + 1.0
        publisher.publish(output)

    node.create_subscription(Float32, "signal", answer, 10)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
