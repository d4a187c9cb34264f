"""ROS 1 side of the bridge."""
