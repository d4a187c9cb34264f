# Pure: knows no ROS.
"""Signal generation: waveforms, their parameters and run times; independent of ROS."""
