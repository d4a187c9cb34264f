# Pure: knows no ROS.
"""Host side of the protocol: synchronization, send queue, pacing. Pure."""
