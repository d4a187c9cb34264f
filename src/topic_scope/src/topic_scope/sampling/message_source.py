# Pure: knows no ROS.
"""Common interface of a node's subscriptions and a played bag."""

from typing import Collection, Iterable, List, Mapping, MutableSequence, NamedTuple, Protocol

#: Assumed time between two messages of a topic with equal times [ns]: the resolution of a page's
#: numbers.
TICK_NS = 500


class Batch(NamedTuple):
    """Messages of one connection.

    :param header: connection header of the publisher
    :param times: times of receipt [ns], unique in a topic
    :param messages: serialized messages
    """

    header: Mapping[str, str]
    times: MutableSequence[int]
    messages: List[bytes]


class Clock(Protocol):
    """Clock of the times of messages."""

    def now(self) -> float:
        """Return the time up to which all messages have arrived [s] since the epoch."""


class Subscription(Protocol):
    """Queue of the messages of one topic."""

    def drain(self) -> Iterable[Batch]:
        """Return the messages since the last call, oldest first."""


class MessageSource(Protocol):
    """Source of the messages of all topics."""

    @property
    def clock(self) -> Clock:
        """Clock of the messages' times."""

    @property
    def has_ended(self) -> bool:
        """Whether no further messages will arrive."""

    def want(self, topics: Collection[str], is_more: bool = False) -> None:
        """Request the messages of these topics, from about now on.

        :param topics: their names
        :param is_more: whether additional fields of them are read
        """

    def subscriptions(self) -> Mapping[str, Subscription]:
        """Return the open subscriptions, by topic."""
