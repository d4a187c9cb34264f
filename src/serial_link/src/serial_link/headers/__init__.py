# Pure: knows no ROS.
"""Messages as C++ classes, for the sketch of a microcontroller."""
