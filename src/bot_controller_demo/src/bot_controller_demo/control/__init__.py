# Pure: knows no ROS.
"""Control laws, from poses to velocities; independent of ROS."""
