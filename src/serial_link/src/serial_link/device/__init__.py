# Pure: knows no ROS.
"""Device side of the protocol: a microcontroller with rosserial's library. Pure."""
