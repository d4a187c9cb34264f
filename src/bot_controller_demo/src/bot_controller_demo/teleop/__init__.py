"""Keys of the teleoperation, and their terminal."""
