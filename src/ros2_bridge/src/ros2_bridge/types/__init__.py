"""Types of either ROS, matched and translated."""
