#!/usr/bin/env python3
"""Run the dc_motor node: see motor_control.nodes.dc_motor."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("motor_control.nodes.dc_motor")
