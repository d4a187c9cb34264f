# Pure: knows no ROS.
"""Pool of a publisher's memory segments.

A segment is written only while no message in it is used. A pool without a free segment grows, up to
its limit in bytes.
"""

from typing import Any, Callable, Dict, List, Optional

#: Most memory of one pool [bytes]: forty pictures of 1920 x 1080 pixels.
MOST_BYTES = 256_000_000
#: A segment that was not used for this long is given back to the system [s].
IDLE_S = 5.0
#: Smallest step between the sizes of segments [bytes].
_STEP = 65_536


def capacity_for(size: int) -> int:
    """Return the size of a new segment, with a reserve for growing messages.

    :param size: size of the message [bytes]
    :returns: the next multiple of an eighth of the largest power of two within the size [bytes]
    """
    step = max(_STEP, (1 << max(size.bit_length() - 1, 0)) >> 3)
    return max(step, -(-size // step) * step)


class Segment:
    """Memory that one message is written to.

    :param number: identifies the segment in its pool
    :param memory: the memory: it has a ``size`` [bytes], and can be closed

    :ivar users: number of uses of its message: it waits for a subscriber, or is being read
    :ivar frame: announcement of its message
    """

    __slots__ = ("number", "memory", "users", "frame", "used_at")

    def __init__(self, number: int, memory: Any) -> None:
        self.number, self.memory = number, memory
        self.users = 0
        self.frame: Any = None
        self.used_at = 0.0


class SegmentPool:
    """Segments of one publisher. Callers hold one lock.

    :param create: creates memory of a size [bytes]; raises an OSError without memory
    :param limit: most memory [bytes]
    """

    def __init__(self, create: Callable[[int], Any], limit: int = MOST_BYTES) -> None:
        self._create, self._limit = create, limit
        self._segments: Dict[int, Segment] = {}
        self._last_number = 0

    def numbers(self) -> List[int]:
        """Return the numbers of all segments."""
        return list(self._segments)

    @property
    def size(self) -> int:
        """Memory of all segments [bytes]."""
        return sum(segment.memory.size for segment in self._segments.values())

    def take(self, size: int, now: float) -> Optional[Segment]:
        """Return a segment to write: the smallest free one that fits, then the latest used.

        A larger one is created if none fits; the free ones, which are too small, are given up.

        :param size: size of the message [bytes]
        :param now: monotonic time [s]
        :returns: the segment, free until its message is used; None if there is no memory for it
        """
        free = [segment for segment in self._segments.values() if not segment.users]
        fitting = [segment for segment in free if segment.memory.size >= size]
        if fitting:
            segment = min(fitting, key=lambda one: (one.memory.size, -one.used_at))
        else:
            self._give_up(free)
            capacity = capacity_for(size)
            if self.size + capacity > self._limit:
                return None
            try:
                memory = self._create(capacity)
            except OSError:
                return None
            self._last_number += 1
            segment = self._segments[self._last_number] = Segment(self._last_number, memory)
        segment.used_at = now
        return segment

    def trim(self, now: float) -> None:
        """Give up free segments that were not used for :data:`IDLE_S`.

        :param now: monotonic time [s]
        """
        segments = self._segments.values()
        self._give_up([one for one in segments if not one.users and now - one.used_at >= IDLE_S])

    def close(self) -> None:
        """Give up all segments; readers keep what they have."""
        self._give_up(list(self._segments.values()))

    def _give_up(self, segments: List[Segment]) -> None:
        for segment in segments:
            del self._segments[segment.number]
            segment.memory.close()
