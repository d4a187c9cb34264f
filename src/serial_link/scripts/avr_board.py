#!/usr/bin/env python3
"""Run the avr_board node: see serial_link.nodes.avr_board."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("serial_link.nodes.avr_board")
