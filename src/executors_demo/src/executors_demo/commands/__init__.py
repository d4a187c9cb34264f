# Pure: knows no ROS.
"""Commands of executors_demo."""
