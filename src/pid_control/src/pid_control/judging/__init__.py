# Pure: knows no ROS.
"""Judging of a controller: scenarios, metrics, limits, diagnosis and reports. Pure."""
