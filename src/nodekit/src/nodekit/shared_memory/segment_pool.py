"""Pool of a publisher's memory segments, and the readers that hold them.

A segment is written only while no reader holds it. Readers of a message hold its segment until they
give it back, or are gone. A pool without a free segment grows, up to its limit in bytes.
"""

from typing import Callable, Dict, Generic, Hashable, Optional, Set, TypeVar

#: Most memory of one pool [bytes]: forty pictures of 1920 x 1080 pixels.
MOST_BYTES = 256_000_000
#: A segment that was not used for this long is given back to the system [s].
IDLE_S = 5.0
#: Smallest step between the sizes of segments [bytes].
_STEP = 65_536

Memory = TypeVar("Memory")


def capacity_for(size: int) -> int:
    """Return the size of a new segment, with a reserve for growing messages.

    :param size: size of the message [bytes]
    :returns: the next multiple of an eighth of the largest power of two within the size [bytes]
    """
    step = max(_STEP, (1 << max(size.bit_length() - 1, 0)) >> 3)
    return max(step, -(-size // step) * step)


class Segment(Generic[Memory]):
    """Memory that one message is written to, and its readers.

    :param number: identifies the segment in its pool
    :param capacity: size [bytes]
    :param memory: the memory, created by the pool's owner

    :ivar holders: readers that may read its message now
    """

    __slots__ = ("number", "capacity", "memory", "holders", "used_at")

    def __init__(self, number: int, capacity: int, memory: Memory) -> None:
        self.number, self.capacity, self.memory = number, capacity, memory
        self.holders: Set[Hashable] = set()
        self.used_at = 0.0


class SegmentPool(Generic[Memory]):
    """Segments of one publisher. Callers hold one lock.

    :param create: creates memory of a size [bytes]; raises an OSError without memory
    :param discard: called with each segment that the pool gives up, which no reader holds
    :param limit: most memory [bytes]
    """

    def __init__(
        self,
        create: Callable[[int], Memory],
        discard: Callable[[Segment[Memory]], None],
        limit: int = MOST_BYTES,
    ) -> None:
        self._create, self._discard, self._limit = create, discard, limit
        self._segments: Dict[int, Segment[Memory]] = {}
        self._last_number = 0

    def __len__(self) -> int:
        return len(self._segments)

    @property
    def size(self) -> int:
        """Memory of all segments [bytes]."""
        return sum(segment.capacity for segment in self._segments.values())

    def take(self, size: int, now: float) -> Optional[Segment[Memory]]:
        """Return a segment to write: the smallest free one that fits, then the latest used.

        A larger one is created if none fits; the free ones, which are too small, are given up.

        :param size: size of the message [bytes]
        :param now: monotonic time [s]
        :returns: the segment, free until it is lent; None if there is no memory for it
        """
        free = [segment for segment in self._segments.values() if not segment.holders]
        fitting = [segment for segment in free if segment.capacity >= size]
        if fitting:
            segment = min(fitting, key=lambda one: (one.capacity, -one.used_at))
        else:
            for segment in free:
                self._give_up(segment)
            capacity = capacity_for(size)
            if self.size + capacity > self._limit:
                return None
            try:
                memory = self._create(capacity)
            except OSError:
                return None
            self._last_number += 1
            segment = Segment(self._last_number, capacity, memory)
            self._segments[segment.number] = segment
        segment.used_at = now
        return segment

    def lend(self, segment: Segment[Memory], reader: Hashable) -> None:
        """Keep a segment unchanged until a reader gives it back.

        :param segment: the segment, from :meth:`take`
        :param reader: the reader
        """
        segment.holders.add(reader)

    def give_back(self, number: int, reader: Hashable) -> bool:
        """End a loan.

        :param number: the segment's number
        :param reader: the reader
        :returns: whether the reader had this segment
        """
        segment = self._segments.get(number)
        if segment is None or reader not in segment.holders:
            return False
        segment.holders.remove(reader)
        return True

    def forget(self, reader: Hashable) -> None:
        """End all loans of a reader that is gone.

        :param reader: the reader
        """
        for segment in self._segments.values():
            segment.holders.discard(reader)

    def readers(self) -> Set[Hashable]:
        """Return the readers that hold a segment."""
        holders = (segment.holders for segment in self._segments.values())
        return set().union(*holders)

    def trim(self, now: float) -> None:
        """Give up free segments that were not used for :data:`IDLE_S`.

        :param now: monotonic time [s]
        """
        for segment in list(self._segments.values()):
            if not segment.holders and now - segment.used_at >= IDLE_S:
                self._give_up(segment)

    def close(self) -> None:
        """Give up all segments; readers keep what they have."""
        for segment in list(self._segments.values()):
            segment.holders.clear()
            self._give_up(segment)

    def _give_up(self, segment: Segment[Memory]) -> None:
        del self._segments[segment.number]
        self._discard(segment)
