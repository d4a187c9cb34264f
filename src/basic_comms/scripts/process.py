#!/usr/bin/env python3
"""Run the process node: see basic_comms.nodes.process."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("basic_comms.nodes.process")
