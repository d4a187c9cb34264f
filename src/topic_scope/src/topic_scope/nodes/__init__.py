"""The node: what wires the oscilloscope to ROS."""
