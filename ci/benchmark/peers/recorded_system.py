#!/usr/bin/env python3
"""The workspace's own motor, recording when it publishes. Usage: ... RECORD"""

import sys

from pid_control.nodes.system import System
from recording import RecordingPublisher

from nodekit import Node, run


class RecordedSystem(System):
    """The motor, with a publisher that records."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._publisher = RecordingPublisher(self._publisher, sys.argv[1], "time")


if __name__ == "__main__":
    run("system", RecordedSystem)
