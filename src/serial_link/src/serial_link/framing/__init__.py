# Pure: knows no ROS.
"""Frames of the wire: encoded and decoded. Pure."""
