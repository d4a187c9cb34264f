"""Base class of bridges: opens and closes ROS 1/ROS 2 pairs of topics, services or actions."""

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

from ros2_bridge.rules.selection import Rules, Route
from ros2_bridge.rules.skip_log import SkipLog

#: A pair is closed after it has been missing in this many consecutive polls: after a restart, the
#: master learns of its nodes only within a second.
MISSED_POLLS = 4


class Closable(Protocol):
    """A bridged resource."""

    def close(self) -> None:
        """Stop bridging it."""


Key = TypeVar("Key", bound=Hashable)
Part = TypeVar("Part", bound=Closable)


def for_all(items: Iterable[Any], function: Callable[[Any], None]) -> None:
    """Call a function with each item, even after a failure.

    :raises Exception: the first failure
    """
    failed: Optional[Exception] = None
    for item in items:
        try:
            function(item)
        except Exception as error:
            failed = failed or error
    if failed is not None:
        raise failed


class BridgedResources(Dict[Key, Part]):
    """Bridged resources by key; each is closed once it has been missing for several polls.

    :param polls: number of consecutive polls without a pair after which it is closed
    """

    def __init__(self, polls: int = MISSED_POLLS) -> None:
        super().__init__()
        self._polls = polls
        self._missed: Dict[Key, int] = {}

    def close_one(self, key: Key) -> None:
        """Close the pair with this key, which must exist."""
        self.pop(key).close()

    def close_missing(self, wanted: Collection[Key]) -> None:
        """Close the pairs that have been missing for several polls.

        :param wanted: keys of the pairs to keep, by this poll
        """
        self._missed = {key: self._missed.get(key, 0) + 1 for key in set(self).difference(wanted)}
        gone = [key for key, missed in self._missed.items() if missed >= self._polls]
        for_all(gone, self.close_one)


class PairBridge(Generic[Part]):
    """Base class of bridges: keeps pairs of topics, services or actions up to date.

    :param skip_log: receives the reasons for missing pairs

    :ivar pairs: active pairs by name and direction
    """

    def __init__(self, skip_log: SkipLog) -> None:
        self._skip_log = skip_log
        self.pairs: BridgedResources[Route, Part] = BridgedResources()

    def update_pairs(self, routes: Sequence[Route]) -> None:
        """Create and close pairs after a poll of both graphs.

        :param routes: names and directions to bridge
        """
        try:
            self.pairs.close_missing(routes)
        finally:
            for_all(routes, self._update_pair)

    def _update_pair(self, route: Route) -> None:
        pair = self.pairs.get(route)
        if pair is not None and not self._has_same_type(route, pair):
            self.pairs.close_one(route)
            return  # create it in the next poll: ROS 2 still has the old type
        if pair is not None and not self._is_as_begun(route, pair):
            self.pairs.close_one(route)
        if route not in self.pairs:
            with self._skip_log.catching(route.name):
                begun = self._begin(route)
                if begun is not None:
                    self.pairs[route] = begun

    def close_denied(self, rules: Rules) -> None:
        """Close pairs immediately that the rules no longer allow.

        :param rules: the user's rules
        """
        for_all([route for route in self.pairs if not rules.enables(route)], self.pairs.close_one)

    def _has_same_type(self, route: Route, pair: Part) -> bool:
        """Return whether a topic or service still has the type of its pair."""
        raise NotImplementedError

    def _is_as_begun(self, route: Route, pair: Part) -> bool:
        """Return whether a new pair would be created in the same way."""
        raise NotImplementedError

    def _begin(self, route: Route) -> Optional[Part]:
        """Return a new pair; None if its type is not known yet, or differs between the ROSes."""
        raise NotImplementedError
