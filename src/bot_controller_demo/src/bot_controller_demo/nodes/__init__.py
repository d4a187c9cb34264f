"""Nodes: ROS interfaces of the control laws and of the keyboard."""
