"""Simulator of a first-order plant, as a ROS node."""
