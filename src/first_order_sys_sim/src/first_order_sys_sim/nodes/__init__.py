"""The node: what wires the plant to ROS."""
