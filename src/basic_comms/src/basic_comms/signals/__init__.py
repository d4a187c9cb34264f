# Pure: knows no ROS.
"""What makes signals: waveforms, their parameters, and when they run. It knows no ROS."""
