"""Common interface of open ROS 1 and ROS 2 recordings."""

from typing import Collection, Dict, Iterable, List, Mapping, NamedTuple, Tuple, TypeVar

import numpy

_Self = TypeVar("_Self", bound="Recording")


class BagError(Exception):
    """Unreadable bag; the text is for the user."""


class Connection(NamedTuple):
    """Connection of a publisher, as the bag records it.

    :param topic: global name of the topic
    :param header: type, definition and more
    """

    topic: str
    header: Mapping[str, str]


class ConnectionMessages(NamedTuple):
    """Messages of one connection.

    :param connection: its number
    :param times: when they were recorded, ascending, since the epoch [ns]
    :param messages: as ROS 1 sends them
    """

    connection: int
    times: numpy.ndarray
    messages: List[bytes]

    def between(self, start: int, end: int) -> "ConnectionMessages":
        """Return the messages from a start up to, but excluding, an end, since the epoch [ns]."""
        first, last = self.times.searchsorted([start, end]).tolist()
        return ConnectionMessages(
            self.connection, self.times[first:last], self.messages[first:last]
        )


class Recording:
    """Open recording, read chunk by chunk; may be used in a ``with`` statement.

    :param path: file or folder

    :ivar path: the same
    :ivar connections: by their numbers; only those with messages
    :ivar start: time of the first message, since the epoch [ns]
    :ivar end: time of the last message
    :ivar faults: topics that cannot be read, and why
    :ivar lost: descriptions of the parts that could not be read
    :ivar left_out: descriptions of the requested lines that are left out
    :ivar notes: descriptions of problems with single messages
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
        """Time from the first to the last message of any topic [ns]."""
        return self.end - self.start

    def count(self, topics: Collection[str]) -> int:
        """Return the number of messages of some topics.

        :param topics: global names
        """
        return sum(self._counts[number] for number in self.numbers_of(topics))

    def numbers_of(self, topics: Collection[str]) -> List[int]:
        """Return the numbers of the connections of some topics, by their global names."""
        return [number for number, one in self.connections.items() if one.topic in topics]

    def earliest(self) -> Dict[int, bytes]:
        """Read an early message of each topic, by the numbers of their connections.

        A topic without a readable message is added to :attr:`faults`.
        """
        raise NotImplementedError

    def chunks_after(self, time: int, last: Iterable[int] = ()) -> "Tuple[List[int], List[int]]":
        """Return the numbers of the chunks with messages later than a time, and their starts.

        :param time: since the epoch [ns]
        :param last: numbers of connections whose last chunk before the time is included
        :returns: in the order of their starts [ns]
        """
        raise NotImplementedError

    def read(self, number: int, wanted: Collection[int]) -> List[ConnectionMessages]:
        """Read the messages of some connections in a chunk.

        :param number: number of the chunk
        :param wanted: numbers of the connections
        :raises BagError: if the chunk is damaged
        """
        raise NotImplementedError

    def close(self) -> None:
        """Close the file."""
        raise NotImplementedError
