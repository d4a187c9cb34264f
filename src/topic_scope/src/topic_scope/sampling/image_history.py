# Pure: knows no ROS.
"""Recent image messages of topics, limited in bytes."""

import bisect
from typing import Collection, Dict, List, Mapping, NamedTuple, Optional

import numpy

from topic_scope.analysis.ring import NOWHERE
from topic_scope.messages.message_layout import MessageLayout
from topic_scope.timing.nanoseconds import shifted, to_ns


#: Maximum size of the image messages of all topics together [bytes].
MOST_BYTES = 128 * 10**6


class StoredImage(NamedTuple):
    """Image message, or the times of a dropped one.

    :param time: its time, by the clock of its topic [ns]
    :param received: time of receipt [ns], unique within a topic
    :param layout: its layout
    :param message: the serialized message; None if it was dropped
    """

    time: int
    received: int
    layout: MessageLayout
    message: Optional[bytes]


class ImageHistory:
    """Recent image messages; a :class:`.MessageSink`.

    Times are kept for the length of the history, messages only up to a number of bytes, but always
    the newest. Messages in the pinned span are dropped last.

    :param history: how long times are kept [s]
    """

    def __init__(self, history: float) -> None:
        self._most = 0
        self._history = to_ns(history)
        self._layout: Optional[MessageLayout] = None
        #: Times of all images, ascending, and their times of receipt.
        self._times: List[int] = []
        self._received: List[int] = []
        #: Images that are not dropped, by their times of receipt, in the order of reception.
        self._kept: Dict[int, StoredImage] = {}
        self._bytes = 0
        self._pinned = NOWHERE

    def read_as(self, layout: MessageLayout) -> None:
        """Read messages with this layout from now on."""
        self._layout = layout

    def add(
        self, messages: List[bytes], times: numpy.ndarray, received: numpy.ndarray, newest: int
    ) -> None:
        """Add messages; see :meth:`.MessageSink.add`."""
        if self._layout is None:
            return
        for message, time, when in zip(messages, times.tolist(), received.tolist()):
            place = bisect.bisect_right(self._times, time)
            self._times.insert(place, time)
            self._received.insert(place, when)
            self._kept[when] = StoredImage(time, when, self._layout, message)
            self._bytes += len(message)
        self._forget(newest - self._history)
        self._drop()

    def move(self, by: int) -> None:
        """Shift all times after the clock was set [ns]."""
        self._times = [time + by for time in self._times]
        self._kept = {when: one._replace(time=one.time + by) for when, one in self._kept.items()}
        self._pinned = shifted(self._pinned[0], by), shifted(self._pinned[1], by)

    def pin(self, start: int, end: int) -> None:
        """Set the span whose messages are dropped last [ns]; an end before the start for none."""
        self._pinned = start, end

    @property
    def most(self) -> int:
        """Maximum size of the messages [bytes]."""
        return self._most

    @most.setter
    def most(self, most: int) -> None:
        self._most = most
        self._drop()

    @property
    def newest(self) -> Optional[StoredImage]:
        """The image that was received last; None without images."""
        return self._kept[next(reversed(self._kept))] if self._kept else None

    def at(self, time: int) -> Optional[StoredImage]:
        """Return the latest image at or before a time [ns]; None if not found."""
        place = bisect.bisect_right(self._times, time) - 1
        if place < 0 or self._layout is None:
            return None
        when = self._received[place]
        dropped = StoredImage(self._times[place], when, self._layout, None)
        return self._kept.get(when, dropped)

    @property
    def first(self) -> Optional[int]:
        """Earliest time [ns]; None without images."""
        return self._times[0] if self._times else None

    @property
    def first_kept(self) -> Optional[int]:
        """Earliest time of an image that was not dropped [ns]; None without such images."""
        return min((one.time for one in self._kept.values()), default=None)

    def _forget(self, before: int) -> None:
        """Remove the images before a time [ns], except in the pinned span, and the newest."""
        count = bisect.bisect_left(self._times, before)
        last = next(reversed(self._kept), None)
        old = [
            place
            for place in range(count)
            if not self._is_pinned(self._times[place]) and self._received[place] != last
        ]
        for place in reversed(old):
            self._release(self._received[place])
            del self._times[place], self._received[place]

    def _drop(self) -> None:
        """Drop messages, oldest first, until the rest is within the limit."""
        if self._bytes <= self._most:
            return
        for pinned in (False, True):
            for one in list(self._kept.values())[:-1]:
                if self._bytes <= self._most:
                    return
                if self._is_pinned(one.time) == pinned:
                    self._release(one.received)

    def _release(self, received: int) -> None:
        dropped = self._kept.pop(received, None)
        if dropped is not None and dropped.message is not None:
            self._bytes -= len(dropped.message)

    def _is_pinned(self, time: int) -> bool:
        start, end = self._pinned
        return start <= time <= end


def histories(
    topics: Collection[str], before: Mapping[str, ImageHistory], history: float
) -> Dict[str, ImageHistory]:
    """Return the histories of topics, which share :data:`MOST_BYTES` equally.

    :param topics: their names
    :param before: the previous histories; those of the same topics are kept
    :param history: how long times are kept [s]
    """
    made = {topic: before.get(topic) or ImageHistory(history) for topic in topics}
    for one in made.values():
        one.most = MOST_BYTES // len(made)
    return made
