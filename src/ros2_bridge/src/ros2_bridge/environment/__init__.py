"""Python environment with ROS 1 and ROS 2, and its activation in a process."""
