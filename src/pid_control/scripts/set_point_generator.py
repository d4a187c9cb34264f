#!/usr/bin/env python3
"""Run the set_point_generator node: see pid_control.nodes.set_point_generator."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("pid_control.nodes.set_point_generator")
