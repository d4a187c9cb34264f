"""Parameter bridge: parameters of each ROS in the other."""
