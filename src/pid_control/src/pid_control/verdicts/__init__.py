# Pure: knows no ROS.
"""Verdicts on submissions: figures, limits, causes, and reports. Pure."""
