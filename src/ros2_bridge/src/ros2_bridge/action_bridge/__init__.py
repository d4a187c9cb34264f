"""Actions of each ROS in the other.

A ROS 2 action consists of three services and two topics, which are used directly: rclpy's action
classes need an executor, and do not deliver feedback as bytes.
"""
