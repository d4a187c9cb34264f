# Pure: knows no ROS.
"""What the process node does to a signal. It knows no ROS."""
