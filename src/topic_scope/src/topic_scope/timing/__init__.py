# Pure: knows no ROS.
"""Times of samples: the clocks of stamps, and their offsets."""
