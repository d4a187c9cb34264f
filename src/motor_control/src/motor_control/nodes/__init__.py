"""The nodes: what wires the motor and its set point to ROS."""
