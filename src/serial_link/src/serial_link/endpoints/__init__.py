"""What the topics, services, parameters and logs of a board are in ROS."""
