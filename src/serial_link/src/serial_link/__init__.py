"""Microcontrollers on a ROS graph, by the protocol of rosserial."""
