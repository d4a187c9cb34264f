"""Message and service types of both ROS versions, matched and translated."""
