"""The laws, wired to ROS: what commands a robot."""
