# Pure: knows no ROS.
"""Where messages come from, a node's subscriptions or a bag: what both have in common."""

from typing import Collection, Iterable, List, Mapping, MutableSequence, NamedTuple, Protocol

#: Time between two messages of a topic that the clock does not tell apart, s: the resolution of a
#: float.
TICK_S = 5e-7


class Batch(NamedTuple):
    """Messages that came over one connection.

    :param header: what the publisher has said of them
    :param times: when they came, s: no two of a topic at the same time
    :param messages: as they came
    """

    header: Mapping[str, str]
    times: MutableSequence[float]
    messages: List[bytes]


class Clock(Protocol):
    """What the times of messages are by."""

    def now(self) -> float:
        """Return the time up to which all messages are there, s since the epoch."""


class Subscription(Protocol):
    """Where the messages of one topic come out."""

    def drain(self) -> Iterable[Batch]:
        """Return what has come since the last call, oldest first."""


class MessageSource(Protocol):
    """Where the messages of all topics come out."""

    @property
    def clock(self) -> Clock:
        """What the messages' times are by."""

    def want(self, topics: Collection[str], is_more: bool = False) -> None:
        """Have the messages of these topics, from now on or a little later.

        :param topics: their names
        :param is_more: whether more is read of them than before
        """

    def subscriptions(self) -> Mapping[str, Subscription]:
        """Return the outlets that are open now, by topic."""
