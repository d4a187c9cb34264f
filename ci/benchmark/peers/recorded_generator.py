#!/usr/bin/env python3
"""The workspace's own signal generator, recording when it publishes. Usage: ... RECORD"""

import sys

from basic_comms.nodes.signal_generator import SignalGenerator

from basic_comms.msg import signal_msg
from ci.benchmark.record import Record
from nodekit import Node, Publisher, run

record = Record(sys.argv[1])


class RecordingPublisher:
    """Stands in for a publisher, which lets nobody change it, and notes when it publishes."""

    def __init__(self, publisher: Publisher) -> None:
        self.resolved_name = publisher.resolved_name
        self._publish = publisher.publish

    def publish(self, message: signal_msg) -> None:
        """Note the sample's own time and the moment just before it is published."""
        record.add(message.time_x)
        self._publish(message)


class RecordedGenerator(SignalGenerator):
    """The generator, with a publisher that records."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self._publisher = RecordingPublisher(self._publisher)


if __name__ == "__main__":
    run("signal_generator", RecordedGenerator)
