# Pure: knows no ROS.
"""Judging of a controller: scenarios, metrics and diagnosis. Pure."""
