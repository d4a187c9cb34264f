# Pure: knows no ROS.
"""The side of the host: when to ask, what to send first, how fast. Pure."""
