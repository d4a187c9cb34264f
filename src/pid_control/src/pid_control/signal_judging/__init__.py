# Pure: knows no ROS.
"""Judging of the first coursework: a signal generator and a process node. Pure."""
