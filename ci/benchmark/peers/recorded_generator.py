#!/usr/bin/env python3
"""The workspace's own signal generator, recording when it publishes. Usage: ... RECORD"""

import sys
from typing import Any

from basic_comms.msg import signal_msg
from basic_comms.nodes import signal_generator
from nodekit.messaging.publisher import Publisher
from record import Record

record = Record()


class RecordingPublisher(Publisher):
    """Notes the moment just before a sample is published, and the sample's own time."""

    def publish(self, *args: Any, **kwds: Any) -> None:
        if self.data_class is signal_msg:
            record.add(args[0].time_x)
        super().publish(*args, **kwds)


if __name__ == "__main__":
    signal_generator.Publisher = RecordingPublisher  # type: ignore[misc]
    try:
        signal_generator.main()
    finally:
        record.write(sys.argv[1])
