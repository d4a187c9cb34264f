"""The bridge's side in ROS 2."""
