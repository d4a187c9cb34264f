#!/usr/bin/env python3
"""Run the system node: see pid_control.nodes.system."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("pid_control.nodes.system")
