# Pure: knows no ROS.
"""Conversion of image messages to files that a browser shows."""
