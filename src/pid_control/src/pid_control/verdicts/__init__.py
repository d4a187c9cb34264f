# Pure: knows no ROS.
"""Verdicts on what students hand in: figures, limits, causes, and reports. Pure."""
