#!/usr/bin/env python3
"""The workspace's own signal generator, recording when it publishes. Usage: ... RECORD"""

import sys

from basic_comms.msg import signal_msg
from basic_comms.nodes.signal_generator import SignalGenerator
from nodekit import Node, run
from record import Record

record = Record()


class RecordedGenerator(SignalGenerator):
    """Notes the moment just before a sample is published, and the sample's own time."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        publish = self._publisher.publish

        def note_and_publish(message: signal_msg) -> None:
            record.add(message.time_x)
            publish(message)

        self._publisher.publish = note_and_publish  # type: ignore[method-assign]


if __name__ == "__main__":
    try:
        run("signal_generator", RecordedGenerator)
    finally:
        record.write(sys.argv[1])
