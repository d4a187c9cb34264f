"""Commands of robot_interfaces_demo."""
