"""ROS 2 side of the bridge."""
