"""ROS 2 node that republishes /chatter on /heard, written as users would."""

import contextlib

import rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import String

rclpy.init()
node = rclpy.create_node("echo")
out = node.create_publisher(String, "/heard", 10)
node.create_subscription(String, "/chatter", out.publish, 10)
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(node)
