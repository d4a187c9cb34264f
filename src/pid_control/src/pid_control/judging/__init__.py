# Pure: knows no ROS.
"""How a controller is judged: scenarios, figures, limits, causes and reports. Pure."""
