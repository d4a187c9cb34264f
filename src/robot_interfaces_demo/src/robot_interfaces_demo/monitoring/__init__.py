# Pure: knows no ROS.
"""State of monitored robots, and checks of their messages; independent of ROS."""
