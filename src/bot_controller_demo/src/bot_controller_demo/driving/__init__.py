"""What tells a robot how to move: the laws, wired to ROS."""
