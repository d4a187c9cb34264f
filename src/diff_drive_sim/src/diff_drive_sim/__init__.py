"""A robot with two wheels as a simulator on a ROS graph."""
