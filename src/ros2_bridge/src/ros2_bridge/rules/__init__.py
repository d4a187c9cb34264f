# Pure: knows no ROS.
"""Rules for what is bridged: names, directions, rates; and reasons for what is not."""
