# Pure: knows no ROS.
"""Goals of actions as either ROS has them: states, ids, cancellations. Knows neither ROS."""
