# Pure: knows no ROS.
"""Samples from bags: played, plotted, written as CSV."""
