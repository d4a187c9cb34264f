# Pure: knows no ROS.
"""Goals of actions: their states, and a server's list of them."""
