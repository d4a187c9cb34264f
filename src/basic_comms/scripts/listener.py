#!/usr/bin/env python3
"""Run the listener node: see basic_comms.nodes.listener."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("basic_comms.nodes.listener")
