# Pure: knows no ROS.
"""Action goals of both ROS versions: states, ids, cancellations; imports neither."""
