"""Look after many things a few at a time."""

from typing import List, Sequence, TypeVar

T = TypeVar("T")


class Turns:
    """Has things take turns.

    :param most: how many have their turn at once
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._from = 0

    def next(self, things: Sequence[T]) -> List[T]:
        """Return whose turn it is, of all things there are now in a lasting order."""
        turn = list(things[self._from :][: self._most])
        self._from += self._most
        if self._from >= len(things):
            self._from = 0
        return turn
