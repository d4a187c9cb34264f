"""Topics, services, parameters and logs of a board in ROS."""
