# Pure: knows no ROS.
"""Host side of the protocol: synchronization, queueing, pacing. Pure."""
