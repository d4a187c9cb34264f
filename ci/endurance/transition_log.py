"""Log of managed nodes: which were active while a node they depend on was not configured."""

from typing import Dict, List, NamedTuple, Sequence, Set


class Entry(NamedTuple):
    """A line of the log: event of a node, and monotonic time [s]."""

    moment: float
    node: str
    what: str


def entries(text: str) -> List[Entry]:
    """Return the lines of a log, oldest first."""
    words = (line.split() for line in text.splitlines())
    return sorted(Entry(float(moment), node, what) for moment, node, what in words)


class NodeStates:
    """State of the nodes after some entries.

    :param order: their names; each depends on its predecessors

    :ivar rash: nodes activated while a predecessor was not configured
    :ivar longest: longest time that a node was active while a predecessor was not configured [s]
    """

    def __init__(self, order: Sequence[str]) -> None:
        self._order = order
        self._configured: Set[str] = set()
        self._active: Set[str] = set()
        self._stopped: Set[str] = set()
        self._wrong_since: Dict[str, float] = {}
        self.rash: List[str] = []
        self.longest = 0.0

    def read(self, entry: Entry) -> None:
        """Add the next entry."""
        moment, node, what = entry
        self.longest = max([self.longest, *(moment - one for one in self._wrong_since.values())])
        self._stopped.discard(node)
        if what in ("started", "killed", "cleaned_up"):
            self._configured.discard(node)
        if what in ("started", "killed", "deactivated"):
            self._active.discard(node)
        for happened, names in (
            ("stopped", self._stopped),
            ("configured", self._configured),
            ("activated", self._active),
        ):
            if what == happened:
                names.add(node)
        for place, name in enumerate(self._order):
            is_safe = self._configured.issuperset(self._order[:place])
            if is_safe or name not in self._active - self._stopped:
                self._wrong_since.pop(name, None)
            else:
                self._wrong_since.setdefault(name, moment)
        if what == "activated" and node in self._wrong_since:
            self.rash.append(f"{node} at {moment:.3f}")

    def all_active(self) -> bool:
        """Return whether all nodes are active."""
        return self._active == set(self._order) and not self._stopped
