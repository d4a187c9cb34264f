#!/usr/bin/env python3
"""The workspace's own motor, recording when it publishes. Usage: ... RECORD"""

import sys

from pid_control.nodes.system import System

from ci.benchmark.record import Record
from nodekit import Node, Publisher, run
from pid_control.msg import motor_output

record = Record(sys.argv[1])


class RecordingPublisher:
    """Stands in for a publisher, which lets nobody change it, and notes when it publishes."""

    def __init__(self, publisher: Publisher) -> None:
        self._publish = publisher.publish

    def publish(self, message: motor_output) -> None:
        """Note the output's own time and the moment just before it is published."""
        record.add(message.time)
        self._publish(message)


class RecordedSystem(System):
    """The motor, with a publisher that records."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._publisher = RecordingPublisher(self._publisher)


if __name__ == "__main__":
    run("system", RecordedSystem)
