"""ROS interface of the control laws: commands, goals and odometry."""
