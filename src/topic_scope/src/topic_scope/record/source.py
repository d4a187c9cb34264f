"""What messages come out of: the subscriptions of a node, or a bag. What both have in common."""

from typing import Collection, Iterable, Mapping, Protocol

from topic_scope.record.taps import Batch


class Times(Protocol):
    """A clock."""

    def now(self) -> float:
        """Return the time up to which all messages are there, s since the epoch."""


class Outlet(Protocol):
    """Where the messages of one topic come out."""

    def take(self) -> Iterable[Batch]:
        """Return what has come since the last call, oldest first."""


class Source(Protocol):
    """Where the messages of all topics come out."""

    @property
    def clock(self) -> Times:
        """What the messages' times are by."""

    def want(self, topics: Collection[str], is_more: bool = False) -> None:
        """Have the messages of these topics, from now on or a little later.

        :param topics: their names
        :param is_more: whether more is read of them than before
        """

    def open(self) -> Mapping[str, Outlet]:
        """Return the outlets that are open now, by topic."""
