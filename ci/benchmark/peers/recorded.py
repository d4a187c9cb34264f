#!/usr/bin/env python3
"""One of the workspace's own nodes, recording when it publishes.

Usage: ... RECORD FIELD MODULE:CLASS. Of each message the value of the field is recorded.
"""

import importlib
import sys
from typing import Any

from ci.benchmark.record import Record
from nodekit import Node, Publisher, run

FILE, FIELD, NODE = sys.argv[1:4]
MODULE, CLASS = NODE.split(":")


class RecordingPublisher:
    """Wrapper of a publisher; a publisher's own method cannot be replaced.

    :param publisher: the node's own
    """

    def __init__(self, publisher: Publisher) -> None:
        self.resolved_name = publisher.resolved_name
        self._publish, self._record = publisher.publish, Record(FILE)

    def publish(self, message: Any) -> None:
        """Record a message, and publish it."""
        self._record.add(getattr(message, FIELD))
        self._publish(message)


class RecordedNode(getattr(importlib.import_module(MODULE), CLASS)):
    """The node, with a publisher that records."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._publisher = RecordingPublisher(self._publisher)


if __name__ == "__main__":
    run(MODULE.rpartition(".")[2], RecordedNode)
