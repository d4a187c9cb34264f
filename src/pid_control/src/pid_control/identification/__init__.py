# Pure: knows no ROS.
"""Identification of a plant from its input and its output: pure, with numpy and scipy."""
