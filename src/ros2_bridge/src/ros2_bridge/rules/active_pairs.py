"""Active pairs: created, kept, replaced and closed; imports neither ROS."""

from typing import (
    Any,
    Callable,
    Collection,
    Dict,
    Generic,
    Hashable,
    Iterable,
    Optional,
    Protocol,
    Sequence,
    TypeVar,
)

from ros2_bridge.rules.selection import Rules, Way
from ros2_bridge.rules.skip_log import SkipLog

#: How many polls of both graphs, one after the other, must miss something until it is closed: a
#: master that was restarted learns of its nodes only within a second.
MISSED_POLLS = 4


class Closable(Protocol):
    """A bridged resource."""

    def close(self) -> None:
        """Bridge it no longer."""


Key = TypeVar("Key", bound=Hashable)
Part = TypeVar("Part", bound=Closable)


def for_all(items: Iterable[Any], function: Callable[[Any], None]) -> None:
    """Call a function with each of some items, also after it has failed for one.

    :raises Exception: the first of the failures
    """
    failed: Optional[Exception] = None
    for item in items:
        try:
            function(item)
        except Exception as error:
            failed = failed or error
    if failed is not None:
        raise failed


class Bridged(Dict[Key, Part]):
    """Active pairs by key; each is closed once it has been missing for several polls.

    :param polls: how many polls, one after the other, must miss it
    """

    def __init__(self, polls: int = MISSED_POLLS) -> None:
        super().__init__()
        self._polls = polls
        self._missed: Dict[Key, int] = {}

    def close_one(self, key: Key) -> None:
        """Close what has a key, which must be there."""
        self.pop(key).close()

    def close_missing(self, wanted: Collection[Key]) -> None:
        """Close what this poll and those before it have missed.

        :param wanted: what this poll says is to be bridged
        """
        self._missed = {key: self._missed.get(key, 0) + 1 for key in set(self).difference(wanted)}
        gone = [key for key, missed in self._missed.items() if missed >= self._polls]
        for_all(gone, self.close_one)


class PairBridge(Generic[Part]):
    """Keeps the pairs of topics, or of services, as both graphs want them.

    :param skip_log: is told what cannot be bridged

    :ivar pairs: what is bridged, by way
    """

    def __init__(self, skip_log: SkipLog) -> None:
        self._skip_log = skip_log
        self.pairs: Bridged[Way, Part] = Bridged()

    def update_pairs(self, ways: Sequence[Way]) -> None:
        """Begin and end what a poll of both graphs asks for.

        :param ways: what is to be bridged
        """
        try:
            self.pairs.close_missing(ways)
        finally:
            for_all(ways, self._update_pair)

    def _update_pair(self, way: Way) -> None:
        pair = self.pairs.get(way)
        if pair is not None and not self._has_same_type(way, pair):
            self.pairs.close_one(way)
            return  # of the new type after the next poll: ROS 2 has the old one until then
        if pair is not None and not self._is_as_begun(way, pair):
            self.pairs.close_one(way)
        if way not in self.pairs:
            with self._skip_log.catching(way.name):
                begun = self._begin(way)
                if begun is not None:
                    self.pairs[way] = begun

    def close_denied(self, rules: Rules) -> None:
        """End at once what the user allows no longer.

        :param rules: what the user allows
        """
        for_all([way for way in self.pairs if not rules.opens(way)], self.pairs.close_one)

    def _has_same_type(self, way: Way, pair: Part) -> bool:
        """Tell whether a topic or service still has the type of its pair."""
        raise NotImplementedError

    def _is_as_begun(self, way: Way, pair: Part) -> bool:
        """Tell whether a pair would be begun in the same way again."""
        raise NotImplementedError

    def _begin(self, way: Way) -> Optional[Part]:
        """Return a new pair; None where its type is not known yet, or each ROS has its own."""
        raise NotImplementedError
