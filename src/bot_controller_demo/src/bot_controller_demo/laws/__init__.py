"""From where a robot is to how it is to move: plain computation, which knows no ROS."""
