"""The bridge, as a node of ROS 1."""
