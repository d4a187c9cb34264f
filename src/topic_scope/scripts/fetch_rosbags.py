#!/usr/bin/env python3
"""Fetch the library that reads ROS 2 recordings: see topic_scope.commands.fetch_rosbags."""

from topic_scope.commands.fetch_rosbags import main

if __name__ == "__main__":
    main()
