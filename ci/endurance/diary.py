"""What the diary of some managed nodes tells: who was active while another was not configured."""

from typing import List, NamedTuple, Sequence


class Entry(NamedTuple):
    """A line of the diary.

    :param moment: when, on a monotonic clock, s
    :param node: whose
    :param what: what has become of it
    """

    moment: float
    node: str
    what: str


def entries(text: str) -> List[Entry]:
    """Return the lines of a diary, oldest first."""
    found = []
    for line in text.splitlines():
        moment, node, what = line.split()
        found.append(Entry(float(moment), node, what))
    return sorted(found)


class Story:
    """What becomes of nodes, entry by entry.

    :param order: their names

    :ivar rash: who was activated while one before it was not configured
    :ivar longest: longest time that one stayed active while one before it was not configured, s
    """

    def __init__(self, order: Sequence[str]) -> None:
        self.order = order
        self.configured = {name: False for name in order}
        self.active = {name: False for name in order}
        self.runs = {name: True for name in order}
        self.rash: List[str] = []
        self.longest = 0.0
        self._wrong_since = {name: float("inf") for name in order}

    def read(self, entry: Entry) -> None:
        """Take in the next entry."""
        moment, node, what = entry
        if what in ("started", "killed", "cleaned_up"):
            self.configured[node] = False
        if what in ("started", "killed", "deactivated"):
            self.active[node] = False
        if what == "configured":
            self.configured[node] = True
        if what == "activated":
            self.active[node] = True
            if self._is_wrong(node):
                self.rash.append(f"{node} at {moment:.3f}")
        self.runs[node] = what != "stopped"
        for name in self.order:
            if moment > self._wrong_since[name]:
                self.longest = max(self.longest, moment - self._wrong_since[name])
            if not self._is_wrong(name):
                self._wrong_since[name] = float("inf")
            elif self._wrong_since[name] == float("inf"):
                self._wrong_since[name] = moment

    def all_active(self) -> bool:
        """Tell whether all are active."""
        return all(self.active.values()) and all(self.runs.values())

    def _is_wrong(self, node: str) -> bool:
        """Tell whether a node works, as one that is stopped does not, on what is not there."""
        before = self.order[: self.order.index(node)]
        works = self.active[node] and self.runs[node]
        return works and not all(self.configured[name] for name in before)
