# Pure: knows no ROS.
"""Frames of the wire: made, and found again in whatever arrives. Pure."""
