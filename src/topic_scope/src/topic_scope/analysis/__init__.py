# Pure: knows no ROS.
"""Computations on samples: bins, measurements, spectra."""
