# Pure: knows no ROS.
"""Limits around a reference trace, and whether another trace keeps within them."""
