# Pure: knows no ROS.
"""The PID controller: pure, with time as an argument."""
