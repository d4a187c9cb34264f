"""Queue of received messages, bounded in bytes."""

import collections
from typing import Deque, List

from ros2_bridge.ros2.received_message import ReceivedMessage


class MessageQueue:
    """Queue of one subscription's messages; the oldest are dropped beyond a size.

    :param most_bytes: total size of the messages; a single message may be larger [bytes]
    """

    def __init__(self, most_bytes: int) -> None:
        self._most_bytes = most_bytes
        self._messages: Deque[ReceivedMessage] = collections.deque()
        self._bytes = 0

    def __len__(self) -> int:
        return len(self._messages)

    def add(self, message: ReceivedMessage) -> None:
        """Add a message, and drop the oldest ones that no longer fit."""
        self._messages.append(message)
        self._bytes += len(message.data)
        while self._bytes > self._most_bytes and len(self._messages) > 1:
            self._pop()

    def pop_batch(self, most_bytes: int) -> List[ReceivedMessage]:
        """Remove and return the oldest messages.

        :param most_bytes: their total size; a single message may be larger [bytes]
        """
        batch: List[ReceivedMessage] = []
        free = most_bytes
        while self._messages and (not batch or len(self._messages[0].data) <= free):
            batch.append(self._pop())
            free -= len(batch[-1].data)
        return batch

    def _pop(self) -> ReceivedMessage:
        message = self._messages.popleft()
        self._bytes -= len(message.data)
        return message
