#!/usr/bin/env python3
"""Run the talker node: see basic_comms.nodes.talker."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("basic_comms.nodes.talker")
