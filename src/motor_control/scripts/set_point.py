#!/usr/bin/env python3
"""Run the set_point node: see motor_control.nodes.set_point."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("motor_control.nodes.set_point")
