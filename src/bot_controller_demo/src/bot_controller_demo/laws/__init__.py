# Pure: knows no ROS.
"""Poses, velocities, and the laws from the ones to the others; they know no ROS."""
