# Pure: knows no ROS.
"""Plots as SVG: pure."""
