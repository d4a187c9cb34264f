"""A node of ROS 2 that repeats on /heard what comes on /chatter, written as users do."""

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
