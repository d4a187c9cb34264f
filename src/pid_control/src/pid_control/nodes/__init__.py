"""The nodes: what wires the motor, its set point and its controller to ROS."""
