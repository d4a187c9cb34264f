"""The nodes: what wires the control laws and the keys to ROS."""
