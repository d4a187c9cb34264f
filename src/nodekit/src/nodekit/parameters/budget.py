"""Bound how often something is done: a few times at once, then only now and then."""

from typing import Dict, Tuple

#: Writes of one parameter that may follow each other at once.
BURST = 20
#: Time after which one more of them may follow, s.
REFILL_S = 1.0


class Budget:
    """A token bucket for each name.

    Two programs that correct each other must not do so in an endless quick loop.
    """

    def __init__(self) -> None:
        #: What was left for a name, and when, s.
        self._left: Dict[str, Tuple[float, float]] = {}

    def allow(self, name: str, now: float) -> bool:
        """Tell whether it may be done now, which is counted then, or only later.

        :param name: what it is done to
        :param now: the time, s
        """
        left, since = self._left.get(name, (float(BURST), now))
        left = min(float(BURST), left + (now - since) / REFILL_S)
        allowed = left >= 1.0
        self._left[name] = (left - 1.0 if allowed else left, now)
        return allowed
