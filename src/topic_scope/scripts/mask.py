#!/usr/bin/env python3
"""Check whether a trace stays within limits around another trace: see topic_scope.commands.mask."""

from nodekit.entry_point import main

if __name__ == "__main__":
    main("topic_scope.commands.mask")
