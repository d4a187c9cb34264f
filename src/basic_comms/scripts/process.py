#!/usr/bin/env python3
"""Run the process node: see basic_comms.nodes.process."""

from basic_comms.nodes.process import main

if __name__ == "__main__":
    main()
