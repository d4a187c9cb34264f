"""A recording that is open, of ROS 1 or of ROS 2: what its readers have in common."""

from typing import Collection, Dict, Iterable, List, Mapping, NamedTuple, Tuple, TypeVar

import numpy

_Self = TypeVar("_Self", bound="Recording")


class BagError(Exception):
    """A bag that cannot be read; the text is for its owner."""


class Connection(NamedTuple):
    """Connection of a publisher, as the bag records it.

    :param topic: global name of the topic
    :param header: type, definition and more
    """

    topic: str
    header: Mapping[str, str]


class Part(NamedTuple):
    """Messages of one connection.

    :param connection: its number
    :param times: when they were recorded, ascending, since the epoch [ns]
    :param messages: as ROS 1 sends them
    """

    connection: int
    times: numpy.ndarray
    messages: List[bytes]

    def between(self, start: int, end: int) -> "Part":
        """Return those of them from one time to before another, since the epoch [ns]."""
        first, last = self.times.searchsorted([start, end]).tolist()
        return Part(self.connection, self.times[first:last], self.messages[first:last])


class Recording:
    """A recording that is open, read chunk by chunk; may be used in a ``with`` statement.

    :param path: file or folder

    :ivar path: the same
    :ivar connections: by their numbers; only those with messages
    :ivar start: time of the first message, since the epoch [ns]
    :ivar end: time of the last one
    :ivar faults: topics that cannot be read, and why
    :ivar lost: parts that could not be read, in words
    :ivar left_out: what else was asked for and is left out, in words
    :ivar notes: problems with single messages that were read, in words
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self.connections: Dict[int, Connection] = {}
        self.start = self.end = 0
        self.faults: Dict[str, str] = {}
        self.lost: List[str] = []
        self.left_out: List[str] = []
        self.notes: List[str] = []
        self._counts: Dict[int, int] = {}

    def __enter__(self: _Self) -> _Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    @property
    def length(self) -> int:
        """The time from the first message to the last of any topic [ns]."""
        return self.end - self.start

    def count(self, topics: Collection[str]) -> int:
        """Return how many messages topics have.

        :param topics: global names
        """
        return sum(self._counts[number] for number in self.numbers_of(topics))

    def numbers_of(self, topics: Collection[str]) -> List[int]:
        """Return the numbers of the connections of some topics, by their global names."""
        return [number for number, one in self.connections.items() if one.topic in topics]

    def earliest(self) -> Dict[int, bytes]:
        """Read an early message of each topic; by the numbers of their connections.

        A topic without one that can be read is among :attr:`faults`.
        """
        raise NotImplementedError

    def chunks_after(self, time: int, last: Iterable[int] = ()) -> "Tuple[List[int], List[int]]":
        """Return the numbers of the chunks that hold messages later than a time, and their starts.

        :param time: since the epoch [ns]
        :param last: numbers of connections; of each the last chunk before that counts, too
        :returns: in the order of their starts [ns]
        """
        raise NotImplementedError

    def read(self, number: int, wanted: Collection[int]) -> List[Part]:
        """Read the messages of some connections in a chunk.

        :param number: of the chunk
        :param wanted: numbers of the connections
        :raises BagError: if the chunk is broken
        """
        raise NotImplementedError

    def close(self) -> None:
        """Close the file."""
        raise NotImplementedError
