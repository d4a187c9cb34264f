"""A first-order system as a plant simulator on a ROS graph."""
