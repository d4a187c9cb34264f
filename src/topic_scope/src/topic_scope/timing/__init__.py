# Pure: knows no ROS.
"""Times of samples: the clock that stamps follow, and one offset for each clock."""
