"""Diary of managed nodes: who was active while a node that it depends on was not configured."""

from typing import List, NamedTuple, Sequence


class Entry(NamedTuple):
    """A line of the diary: what happened to a node, and when on a monotonic clock [s]."""

    moment: float
    node: str
    what: str


def entries(text: str) -> List[Entry]:
    """Return the lines of a diary, oldest first."""
    words = (line.split() for line in text.splitlines())
    return sorted(Entry(float(moment), node, what) for moment, node, what in words)


class Story:
    """State of the nodes after some entries.

    :param order: their names; each depends on those before it

    :ivar rash: nodes activated while one before them was not configured
    :ivar longest: longest time that a node stayed active while one before it was not configured [s]
    """

    def __init__(self, order: Sequence[str]) -> None:
        self._order = order
        self._configured = {name: False for name in order}
        self._active = {name: False for name in order}
        self._runs = {name: True for name in order}
        self._wrong_since = {name: float("inf") for name in order}
        self.rash: List[str] = []
        self.longest = 0.0

    def read(self, entry: Entry) -> None:
        """Add the next entry."""
        moment, node, what = entry
        if what in ("started", "killed", "cleaned_up"):
            self._configured[node] = False
        if what in ("started", "killed", "deactivated"):
            self._active[node] = False
        if what == "configured":
            self._configured[node] = True
        self._runs[node] = what != "stopped"
        if what == "activated":
            self._active[node] = True
            if self._is_wrong(node):
                self.rash.append(f"{node} at {moment:.3f}")
        for name in self._order:
            if moment > self._wrong_since[name]:
                self.longest = max(self.longest, moment - self._wrong_since[name])
            if not self._is_wrong(name):
                self._wrong_since[name] = float("inf")
            elif self._wrong_since[name] == float("inf"):
                self._wrong_since[name] = moment

    def all_active(self) -> bool:
        """Return whether all nodes are active."""
        return all(self._active.values()) and all(self._runs.values())

    def _is_wrong(self, node: str) -> bool:
        """Return whether a node is active, and not stopped, while one before it is missing."""
        before = self._order[: self._order.index(node)]
        works = self._active[node] and self._runs[node]
        return works and not all(self._configured[name] for name in before)
