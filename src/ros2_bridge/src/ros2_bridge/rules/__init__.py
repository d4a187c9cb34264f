# Pure: knows no ROS.
"""Selection of what is bridged: names, directions, rates; and reasons for what is not."""
