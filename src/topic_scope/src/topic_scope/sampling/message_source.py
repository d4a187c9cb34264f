# Pure: knows no ROS.
"""Common interface of a node's subscriptions and a played bag."""

from typing import Collection, Iterable, List, Mapping, MutableSequence, NamedTuple, Protocol

#: Time between two messages of a topic that the clock does not tell apart [ns]: a page's numbers
#: do.
TICK_NS = 500


class Batch(NamedTuple):
    """Messages that came over one connection.

    :param header: what the publisher has said of them
    :param times: when they came [ns]: no two of a topic at the same time
    :param messages: as they came
    """

    header: Mapping[str, str]
    times: MutableSequence[int]
    messages: List[bytes]


class Clock(Protocol):
    """Clock of the times of messages."""

    def now(self) -> float:
        """Return the time up to which all messages are there [s] since the epoch."""


class Subscription(Protocol):
    """Queue of the messages of one topic."""

    def drain(self) -> Iterable[Batch]:
        """Return what has come since the last call, oldest first."""


class MessageSource(Protocol):
    """Source of the messages of all topics."""

    @property
    def clock(self) -> Clock:
        """Clock of the messages' times."""

    @property
    def has_ended(self) -> bool:
        """Whether no more messages will come by its clock."""

    def want(self, topics: Collection[str], is_more: bool = False) -> None:
        """Request the messages of these topics, from now on or a little later.

        :param topics: their names
        :param is_more: whether more is read of them than before
        """

    def subscriptions(self) -> Mapping[str, Subscription]:
        """Return the open subscriptions, by topic."""
