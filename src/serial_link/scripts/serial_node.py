#!/usr/bin/env python3
"""Run the serial_node node: see serial_link.nodes.serial_node."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("serial_link.nodes.serial_node")
