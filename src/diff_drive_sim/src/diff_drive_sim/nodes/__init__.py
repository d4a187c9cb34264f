"""The nodes: what wires robots to ROS."""
