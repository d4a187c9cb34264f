# Pure: knows no ROS.
"""What a plant is like, from a record of its input and its output: pure, with numpy and scipy."""
