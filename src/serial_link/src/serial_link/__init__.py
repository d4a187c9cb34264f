"""Microcontrollers as ROS nodes, through the rosserial protocol."""
