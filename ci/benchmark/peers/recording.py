"""Publisher of the workspace's nodes that records when it publishes."""

from typing import Any

from ci.benchmark.record import Record
from nodekit import Publisher


class RecordingPublisher:
    """Stand-in for a publisher, whose own method cannot be replaced.

    :param publisher: the node's own
    :param file: of the record
    :param field: of the messages whose value is recorded, just before they are published
    """

    def __init__(self, publisher: Publisher, file: str, field: str) -> None:
        self.resolved_name = publisher.resolved_name
        self._publish = publisher.publish
        self._record = Record(file)
        self._field = field

    def publish(self, message: Any) -> None:
        """Record a message, and publish it."""
        self._record.add(getattr(message, self._field))
        self._publish(message)
