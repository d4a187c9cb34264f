# Pure: knows no ROS.
"""From a model to the gains of a controller: pure."""
