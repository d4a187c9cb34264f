# Pure: knows no ROS.
"""What board and host tell each other of topics, services, parameters and logs. Pure."""
