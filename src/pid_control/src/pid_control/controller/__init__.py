# Pure: knows no ROS.
"""The control law: pure, with time as an argument."""
