# Pure: knows no ROS.
"""C++ classes of messages, for the sketch of a microcontroller."""
