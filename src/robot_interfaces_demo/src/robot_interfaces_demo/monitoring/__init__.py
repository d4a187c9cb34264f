# Pure: knows no ROS.
"""What a monitor knows of its robots, and how it judges them: it knows no ROS."""
