# Pure: knows no ROS.
"""Motion and sensing of a robot; independent of ROS."""
