#!/usr/bin/env python3
"""Tell the robot where to go: see humanoid_robot_bringup.robot_control."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("humanoid_robot_bringup.robot_control")
