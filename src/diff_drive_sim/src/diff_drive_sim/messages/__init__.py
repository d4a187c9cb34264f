"""Messages of the robot."""
