"""Nodes of robot_interfaces_demo."""
