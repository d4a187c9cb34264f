# Pure: knows no ROS.
"""Mask tests: limits around a reference trace, and the check of another trace against them."""
