"""Simulator of a differential-drive robot, as a ROS node."""
