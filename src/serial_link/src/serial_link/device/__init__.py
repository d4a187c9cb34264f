# Pure: knows no ROS.
"""The side of a board: what a microcontroller with rosserial does. Pure."""
