# Pure: knows no ROS.
"""Callback groups, and what waits for a thread of an executor."""
