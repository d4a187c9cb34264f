# Pure: knows no ROS.
"""Round-robin selection from a list: each call returns the next few items; independent of ROS."""

from typing import List, Sequence, TypeVar

T = TypeVar("T")


class RoundRobin:
    """Round robin over a list that may change between two calls.

    :param most: largest number of items in one turn
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._from = 0

    def next(self, items: Sequence[T]) -> List[T]:
        """Return the items of the next turn.

        :param items: all present items, in a stable order
        """
        turn = list(items[self._from :][: self._most])
        self._from += self._most
        if self._from >= len(items):
            self._from = 0
        return turn
