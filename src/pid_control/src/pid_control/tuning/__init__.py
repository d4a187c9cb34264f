# Pure: knows no ROS.
"""Tuning of a controller for a model: pure."""
