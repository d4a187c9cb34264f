"""Managed nodes, as in ROS 2; the table of their states is pure."""
