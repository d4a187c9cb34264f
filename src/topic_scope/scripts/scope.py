#!/usr/bin/env python3
"""Run the oscilloscope: see topic_scope.nodes.scope."""

from topic_scope.nodes.scope import main

if __name__ == "__main__":
    main()
