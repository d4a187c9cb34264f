#!/usr/bin/env python3
"""Run the oscilloscope: see topic_scope.nodes.scope."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("topic_scope.nodes.scope")
