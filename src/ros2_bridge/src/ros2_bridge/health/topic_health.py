"""Rates and recent faults of topics, computed from their counters."""

import collections
from typing import Deque, Dict, List, Mapping, NamedTuple, Tuple

from ros2_bridge.rules.selection import Route

#: Time over which rates are averaged [s].
WINDOW_S = 5.0
#: Time for which a fault counts as recent [s].
RECENT_S = 10.0


class TopicCounts(NamedTuple):
    """Counters of a topic in one direction, since it was bridged.

    :param passed: messages passed on
    :param lost: messages lost on the way from ROS 2
    :param refused: messages that are malformed or that the other ROS cannot represent
    :param unread: messages dropped for subscribers in ROS 1 that do not read
    :param thinned: messages dropped by ``max_rate``, which is no fault
    :param held: bytes held for subscribers in ROS 1; to ROS 2 an upper bound, because ROS 2 does
        not report the current number
    """

    passed: int = 0
    lost: int = 0
    refused: int = 0
    unread: int = 0
    thinned: int = 0
    held: int = 0


#: Description of each fault counter.
FAULTS = {
    "lost": "lost on the way from ROS 2",
    "refused": "refused",
    "unread": "dropped for subscribers that do not read",
}


class TopicHealth(NamedTuple):
    """State of a topic in one direction.

    :param counts: its counters
    :param rate: messages passed on [Hz]
    :param recent: number of recent faults by counter, without zeros
    """

    counts: TopicCounts
    rate: float
    recent: Mapping[str, int]


class TopicHealthMonitor:
    """Monitor that derives rates and recent faults from the counters of all topics."""

    def __init__(self) -> None:
        self._passed: Deque[Tuple[float, Dict[Route, int]]] = collections.deque()
        self._before: Dict[Route, TopicCounts] = {}
        self._faults: Dict[Route, List[Tuple[float, str, int]]] = {}

    def update(self, now: float, topics: Mapping[Route, TopicCounts]) -> Dict[Route, TopicHealth]:
        """Return the state of each topic.

        :param now: monotonic time [s]
        :param topics: the current counters of each topic
        """
        while len(self._passed) > 1 and self._passed[0][0] < now - WINDOW_S:
            self._passed.popleft()
        for route, before in list(self._before.items()):
            is_restarted = route in topics and topics[route].passed < before.passed
            if is_restarted or route not in topics:
                self._forget(route)
        states = {
            route: TopicHealth(
                counts, self._rate(now, route, counts), self._recent(now, route, counts)
            )
            for route, counts in topics.items()
        }
        self._passed.append((now, {route: counts.passed for route, counts in topics.items()}))
        self._before = dict(topics)
        self._faults = {route: faults for route, faults in self._faults.items() if route in topics}
        return states

    def _forget(self, route: Route) -> None:
        del self._before[route]
        for _, passed in self._passed:
            passed.pop(route, None)

    def _rate(self, now: float, route: Route, counts: TopicCounts) -> float:
        """Return the rate since the oldest time in the window at which the topic was bridged."""
        for then, passed in self._passed:
            if route in passed and then < now:
                return (counts.passed - passed[route]) / (now - then)
        return 0.0

    def _recent(self, now: float, route: Route, counts: TopicCounts) -> Mapping[str, int]:
        before = self._before.get(route, TopicCounts())
        faults = [one for one in self._faults.get(route, ()) if now < one[0] + RECENT_S]
        for name in FAULTS:
            # The sum over subscribers decreases when one disconnects: no fault.
            growth = getattr(counts, name) - getattr(before, name)
            if growth > 0:
                faults.append((now, name, growth))
        self._faults[route] = faults
        found: Dict[str, int] = {}
        for _, name, growth in faults:
            found[name] = found.get(name, 0) + growth
        return found
