"""Debian packages, the container image, releases, and the wheels of ROS 2."""
