#!/usr/bin/env python3
"""Run the scope with a quarter of the frames a second, for tests that are not about their rate."""

from nodekit.entry_point import main
from topic_scope.web import frame_sender

if __name__ == "__main__":
    frame_sender.FRAME_S *= 4.0
    main("topic_scope.nodes.scope")
