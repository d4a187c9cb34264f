# Pure: knows no ROS.
"""The motor: pure, with time as an argument."""
