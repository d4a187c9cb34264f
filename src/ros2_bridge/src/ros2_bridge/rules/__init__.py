# Pure: knows no ROS.
"""What is bridged, under which name, in which direction, until when; what is not, and why."""
