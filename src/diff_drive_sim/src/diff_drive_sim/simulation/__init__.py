# Pure: knows no ROS.
"""How a robot moves and what it sees: plain computation, which knows no ROS."""
