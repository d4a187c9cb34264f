# Pure: knows no ROS.
"""Signal conditioning of the process node; independent of ROS."""
