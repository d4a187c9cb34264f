# Pure: knows no ROS.
"""Encoder and decoder of rosserial frames. Pure."""
