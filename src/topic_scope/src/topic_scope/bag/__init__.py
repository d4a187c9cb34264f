# Pure: knows no ROS.
"""Bags: reading, playback, plots and CSV files."""
