"""What the robot receives and publishes."""
