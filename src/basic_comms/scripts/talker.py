#!/usr/bin/env python3
"""Run the talker node: see basic_comms.nodes.talker."""

from basic_comms.nodes.talker import main

if __name__ == "__main__":
    main()
