"""Actions of each ROS in the other.

An action of ROS 2 is three services and two topics, and they are served and used as such: rclpy's
own classes for actions need an executor, and get no feedback as bytes.
"""
