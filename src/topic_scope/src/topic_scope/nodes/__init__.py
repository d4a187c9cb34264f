"""ROS node of the oscilloscope."""
