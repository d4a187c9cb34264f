"""Connection to a subscriber that reads large messages from shared memory.

The connection announces them, in order with the others. A message is held like any other if the
subscriber has :data:`MOST_IN_FLIGHT` unread messages.
"""

import contextlib
import select
import threading
import time
from typing import Any, ContextManager, Optional, Sequence, Set, Tuple

from nodekit.shared_memory.channel import ChannelError, WriterChannel
from nodekit.shared_memory.frame import Frame
from nodekit.shared_memory.memory import WrittenMemory
from nodekit.shared_memory.segment_pool import IDLE_S, Segment, SegmentPool
from nodekit.transport.subscriber_connection import Delivery, SubscriberConnection

#: Messages of at least this size go through shared memory [bytes]: to one subscriber, smaller ones
#: take less time by TCP.
LEAST_BYTES = 262_144
#: Most announced messages that a subscriber has not read; fewer with a smaller depth, but always
#: two, so that it may use one while the next arrives.
MOST_IN_FLIGHT, LEAST_IN_FLIGHT = 4, 2


class TopicMemory:
    """Memory of the large messages of one topic. Callers hold the topic's lock.

    :param lock: that lock
    """

    def __init__(self, lock: ContextManager[Any]) -> None:
        self._lock = lock
        self.pool = SegmentPool(WrittenMemory)
        self._channels: Set[WriterChannel] = set()
        self._trimmer: Optional[threading.Timer] = None

    def add(self, channel: WriterChannel) -> None:
        """Add a subscriber's channel."""
        self._channels.add(channel)

    def write(self, parts: Sequence[Any], start: int, stop: int, field: int) -> Optional[Segment]:
        """Write a message to a free segment.

        :param parts: the message's parts, bytes-like
        :param start: begin of its large array [bytes]
        :param stop: end of the array [bytes]
        :param field: number of the array's field
        :returns: the segment, to be sent to subscribers immediately; None without a free one
        """
        self.collect()
        size = sum(map(len, parts))
        segment = self.pool.take(size, time.monotonic())
        if segment is not None:
            segment.memory.write(parts)
            segment.frame = Frame(segment.number, size, start, stop, field, 0)
            self._trim_later()
        return segment

    def collect(self) -> None:
        """Reclaim segments that subscribers have read; remove subscribers that are gone."""
        self._channels = {channel for channel in self._channels if channel.collect()}

    def close(self) -> None:
        """Give back all memory; subscribers keep what they have not read."""
        for channel in self._channels:
            channel.close()
        self._channels.clear()
        self.pool.close()
        if self._trimmer is not None:
            self._trimmer.cancel()

    def _trim_later(self) -> None:
        """Check for unused memory in :data:`.IDLE_S`, in a thread that ends without memory."""
        if self._trimmer is None:
            trimmer = threading.Timer(IDLE_S, self._trim)
            trimmer.daemon, trimmer.name = True, "shared memory"
            with contextlib.suppress(RuntimeError):  # no thread: the next message retries
                trimmer.start()
                self._trimmer = trimmer

    def _trim(self) -> None:
        with self._lock:
            self._trimmer = None
            self.collect()
            self.pool.trim(time.monotonic())
            if self.pool.size:
                self._trim_later()


class _Announcement(Delivery):
    """Announcement of a message; keeps its segment for the subscriber.

    :param segment: the segment
    :param link: the connection
    """

    __slots__ = ("_segment", "_link")

    def __init__(self, segment: Segment, link: "SharedConnection") -> None:
        super().__init__(b"", 1)
        self.size = segment.frame.size
        self._segment, self._link = segment, link
        segment.users += 1

    @property
    def has_begun(self) -> bool:
        """Whether the subscriber has the segment, so that the announcement has to follow."""
        return bool(self.unsent)

    def prepare(self) -> None:
        """Pass the segment to the subscriber, before the first part."""
        if not self.has_begun:
            self._link.pass_segment(self._segment)
            self.drop()
            frame = self._segment.frame._replace(lost=self._link.lost)
            self.unsent = memoryview(frame.pack())

    def drop(self) -> None:
        """Give up the message for this subscriber."""
        if not self.has_begun:
            self._segment.users -= 1


class SharedConnection(SubscriberConnection):
    """Connection to a subscriber that may read large messages from shared memory.

    :param name: name of the receiver, for reports
    :param sock: connected stream socket
    :param lock: lock of all deliveries to this connection
    :param depth: as in :class:`.SubscriberConnection`
    :param memory: memory of the topic
    :param offer: name of the subscriber's channel; empty without one
    """

    def __init__(
        self,
        name: str,
        sock: Any,
        lock: ContextManager[Any],
        depth: Optional[int],
        memory: TopicMemory,
        offer: str,
    ) -> None:
        super().__init__(name, sock, lock, depth)
        self._memory, self._offer = memory, offer
        self._channel: Optional[WriterChannel] = None

    def shares(self) -> bool:
        """Return whether large messages go through shared memory; open the channel if needed."""
        offer, self._offer = self._offer, ""
        if offer:
            try:
                self._channel = WriterChannel(offer)
            except OSError as error:
                self.on_rejected(str(error))
                return False
            self._memory.add(self._channel)
            self.on_shared()
        return self._channel is not None

    def on_shared(self) -> None:
        """Handle that large messages go through shared memory from now on."""

    def on_rejected(self, why: str) -> None:
        """Handle that large messages go over the connection, since there is no channel.

        :param why: the reason
        """

    def share(self, segment: Segment) -> bool:
        """Send a message from shared memory without waiting; hold its announcement if needed.

        :param segment: the segment with the message
        :returns: whether the receiver needs no service, since nothing is held, or held before
        """
        was_held = bool(self.held)
        self.append(_Announcement(segment, self))
        if was_held:
            return True
        self._took_data_at = time.monotonic()
        return self.flush(self._took_data_at)

    def pass_segment(self, segment: Segment) -> None:
        """Pass a segment to the subscriber, before its message is announced.

        :param segment: the segment
        :raises BlockingIOError: if the subscriber has too many unread messages
        :raises OSError: if it has gone
        """
        channel = self._channel
        assert channel is not None
        if self._is_at_limit():
            self._memory.collect()
        if channel.fileno() < 0:
            raise ChannelError("the subscriber is gone")
        if self._is_at_limit():
            raise BlockingIOError
        channel.announce(segment, self._memory.pool.numbers())

    def _is_at_limit(self) -> bool:
        assert self._channel is not None
        depth = MOST_IN_FLIGHT if self.depth is None else self.depth
        most = min(max(depth, LEAST_IN_FLIGHT), MOST_IN_FLIGHT)
        return len(self._channel.in_flight) >= most

    def awaited(self) -> Tuple[int, int]:
        """Return the descriptor and the events of ``poll(2)`` to wait for before :meth:`flush`."""
        try:
            first: Optional[Delivery] = self.held[0]
        except IndexError:  # without the lock, another thread may have sent it
            first = None
        if isinstance(first, _Announcement) and not first.has_begun and self._is_at_limit():
            assert self._channel is not None
            if self._channel.fileno() >= 0:  # otherwise the next flush ends the connection
                return self._channel.fileno(), select.POLLIN
        return super().awaited()
