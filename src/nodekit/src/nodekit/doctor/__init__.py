"""Checks of a ROS system: its master, its machine, its workspace, its graph."""
