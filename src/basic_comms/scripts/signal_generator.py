#!/usr/bin/env python3
"""Run the signal_generator node: see basic_comms.nodes.signal_generator."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("basic_comms.nodes.signal_generator")
