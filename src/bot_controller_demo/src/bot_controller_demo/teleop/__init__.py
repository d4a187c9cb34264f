"""Keys of the teleoperation, and the terminal that they come from."""
