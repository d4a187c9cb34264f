#!/usr/bin/env python3
"""The workspace's own signal generator, recording when it publishes. Usage: ... RECORD"""

import sys

from basic_comms.nodes.signal_generator import SignalGenerator
from recording import RecordingPublisher

from nodekit import Node, run


class RecordedGenerator(SignalGenerator):
    """The generator, with a publisher that records."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._publisher = RecordingPublisher(self._publisher, sys.argv[1], "time_x")


if __name__ == "__main__":
    run("signal_generator", RecordedGenerator)
