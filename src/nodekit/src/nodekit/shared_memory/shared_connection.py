"""Connection to a subscriber that reads large messages from shared memory.

The connection announces them, in order with the others. A message is held like any other if the
subscriber has :data:`MOST_IN_FLIGHT` unread messages.
"""

import contextlib
import logging
import select
import threading
import time
from typing import Any, ContextManager, Dict, NamedTuple, Optional, Sequence, Set, Tuple

from nodekit.shared_memory.channel import ChannelError, Offer, OfferRejected, WriterChannel
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


class SharedMessage(NamedTuple):
    """Message in a segment."""

    segment: Segment[WrittenMemory]
    #: length of the message, and begin and end of its large array [bytes]
    size: int
    start: int
    stop: int
    #: number of the array's field
    field: int


class TopicMemory:
    """Memory of the large messages of one topic. Callers hold the topic's lock.

    :param lock: that lock
    """

    def __init__(self, lock: ContextManager[Any]) -> None:
        self._lock = lock
        self._pool: SegmentPool[WrittenMemory] = SegmentPool(WrittenMemory, self._discard)
        self._channels: Set[WriterChannel] = set()

    def segments(self) -> int:
        """Return the number of segments."""
        return len(self._pool)

    def add(self, channel: WriterChannel) -> None:
        """Add a subscriber's channel."""
        self._channels.add(channel)

    def write(
        self, parts: Sequence[Any], start: int, stop: int, field: int
    ) -> Optional[SharedMessage]:
        """Write a message to a free segment.

        :param parts: the message's parts, bytes-like
        :param start: begin of its large array [bytes]
        :param stop: end of the array [bytes]
        :param field: number of the array's field
        :returns: the message, to be sent to subscribers immediately; None without a free segment
        """
        self.collect()
        size = sum(map(len, parts))
        segment = self._pool.take(size, time.monotonic())
        if segment is None:
            return None
        segment.memory.write(parts)
        _keeper.watch(self, self._lock)
        return SharedMessage(segment, size, start, stop, field)

    def lend(self, message: SharedMessage, channel: WriterChannel) -> None:
        """Keep a message until a subscriber has read it."""
        self._pool.lend(message.segment, channel)

    def give_back(self, number: int, channel: WriterChannel) -> None:
        """End the loan of a segment."""
        self._pool.give_back(number, channel)

    def collect(self) -> None:
        """Reclaim segments that subscribers have read; remove subscribers that are gone."""
        for channel in list(self._channels):
            try:
                for number in channel.returned():
                    self._pool.give_back(number, channel)
            except ChannelError:
                self._channels.discard(channel)
                self._pool.forget(channel)
                channel.close()

    def trim(self) -> None:
        """Give back memory that is not used any longer."""
        self.collect()
        self._pool.trim(time.monotonic())

    def close(self) -> None:
        """Give back all memory; subscribers keep what they have not read."""
        channels, self._channels = self._channels, set()
        for channel in channels:  # first: a subscriber then drops its segments
            channel.close()
        self._pool.close()

    def _discard(self, segment: Segment[WrittenMemory]) -> None:
        for channel in self._channels:
            channel.retire(segment.number)
        segment.memory.close()


class _Announcement(Delivery):
    """Announcement of a message; keeps the segment for the subscriber.

    :param message: the message
    :param link: the connection
    """

    __slots__ = ("_message", "_link")

    def __init__(self, message: SharedMessage, link: "SharedConnection") -> None:
        super().__init__(b"", 1)
        self.size = message.size
        self._message, self._link = message, link

    @property
    def has_begun(self) -> bool:
        """Whether a part is sent, so that the rest has to follow."""
        return bool(self.unsent)

    def prepare(self) -> None:
        """Pass the segment to the subscriber, before the first part."""
        if self.unsent:
            return
        segment = self._message.segment
        self._link.pass_segment(segment)
        frame = Frame(segment.number, *self._message[1:], self._link.lost)
        self.unsent = memoryview(frame.pack())

    def drop(self) -> None:
        """Give up the message for this subscriber."""
        if not self.unsent:
            self._link.give_back(self._message.segment.number)


class SharedConnection(SubscriberConnection):
    """Connection to a subscriber that may read large messages from shared memory.

    :param name: name of the receiver, for reports
    :param sock: connected stream socket
    :param lock: lock of all deliveries to this connection
    :param depth: as in :class:`.SubscriberConnection`
    :param memory: memory of the topic
    :param offer: address of the subscriber's channel; None without one
    """

    def __init__(
        self,
        name: str,
        sock: Any,
        lock: ContextManager[Any],
        depth: Optional[int],
        memory: TopicMemory,
        offer: Optional[Offer],
    ) -> None:
        super().__init__(name, sock, lock, depth)
        self._memory, self._offer = memory, offer
        self._channel: Optional[WriterChannel] = None

    def shares(self) -> bool:
        """Return whether large messages go through shared memory; open the channel if needed."""
        if self._channel is None and self._offer is not None:
            offer, self._offer = self._offer, None
            try:
                self._channel = WriterChannel(offer)
            except OfferRejected as error:
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

    def share(self, message: SharedMessage) -> bool:
        """Send a message from shared memory without waiting; hold its announcement if needed.

        :param message: the message
        :returns: whether the receiver needs no service, since nothing is held, or held before
        """
        assert self._channel is not None
        self._memory.lend(message, self._channel)
        was_held = bool(self.held)
        self.append(_Announcement(message, self))
        now = time.monotonic()
        if was_held:
            return True
        self._took_data_at = now
        return self.flush(now)

    def pass_segment(self, segment: Segment[WrittenMemory]) -> None:
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
        channel.announce(segment.number, segment.memory.descriptor)

    def _is_at_limit(self) -> bool:
        assert self._channel is not None
        depth = MOST_IN_FLIGHT if self.depth is None else self.depth
        most = min(max(depth, LEAST_IN_FLIGHT), MOST_IN_FLIGHT)
        return len(self._channel.in_flight) >= most

    def give_back(self, number: int) -> None:
        """End the loan of a message that is not announced.

        :param number: number of its segment
        """
        assert self._channel is not None
        self._memory.give_back(number, self._channel)

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


class _Keeper:
    """Thread that gives back unused memory of topics; ends when no memory is left."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._memories: Dict[TopicMemory, ContextManager[Any]] = {}
        self._is_running = False

    def watch(self, memory: TopicMemory, lock: ContextManager[Any]) -> None:
        if memory in self._memories:
            return
        with self._lock, contextlib.suppress(RuntimeError):  # no thread: the next message retries
            if not self._is_running:
                threading.Thread(target=self._run, name="shared memory", daemon=True).start()
                self._is_running = True
            self._memories[memory] = lock

    def _run(self) -> None:
        while True:
            time.sleep(IDLE_S / 2.0)
            with self._lock:
                memories = list(self._memories.items())
            for memory, lock in memories:
                try:
                    self._trim(memory, lock)
                except Exception:
                    logging.getLogger(__name__).exception("shared memory is not given back")
            with self._lock:
                if not self._memories:
                    self._is_running = False
                    return

    def _trim(self, memory: TopicMemory, lock: ContextManager[Any]) -> None:
        with lock:
            memory.trim()
            if not memory.segments():
                with self._lock:
                    self._memories.pop(memory, None)


_keeper = _Keeper()
