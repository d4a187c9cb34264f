# Pure: knows no ROS.
"""SVG plots: pure."""
