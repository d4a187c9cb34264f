# Pure: knows no ROS.
"""What is computed of samples: bins, measures, spectra."""
