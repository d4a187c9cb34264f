"""Messages that the robot receives and publishes."""
