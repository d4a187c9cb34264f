# Pure: knows no ROS.
