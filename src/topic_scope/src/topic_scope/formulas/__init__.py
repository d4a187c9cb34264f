# Pure: knows no ROS.
"""Traces computed from others by an expression that is typed: read, checked, evaluated."""
