#!/usr/bin/env python3
"""Run the signal_generator node: see basic_comms.nodes.signal_generator."""

from basic_comms.nodes.signal_generator import main

if __name__ == "__main__":
    main()
