# Pure: knows no ROS.
"""Callback groups, and the ready queue of an executor."""
