"""Mutation tests of the pure modules and of those that connect to ROS."""
