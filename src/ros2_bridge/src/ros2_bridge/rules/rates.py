"""Maximum rates of topics; imports neither ROS."""

import fnmatch
import math
from typing import List, Sequence, Tuple


class MaxRates:
    """Maximum rate of each topic.

    :param rules: each ``PATTERN=HZ``, such as ``/camera/*=10``; the first match applies
    :raises ValueError: if a rule is malformed; the text is a clause that states the requirement
    """

    def __init__(self, rules: Sequence[str] = ()) -> None:
        self._rates: List[Tuple[str, float]] = []
        for rule in rules:
            pattern, _, text = rule.rpartition("=")
            try:
                rate = float(text)
            except ValueError:
                rate = math.nan
            if not pattern or not 0.0 < rate < math.inf:
                raise ValueError(
                    "each rule must be PATTERN=HZ, a number above 0, such as /camera/*=10;"
                    f" {rule!r} is not"
                )
            self._rates.append((pattern, rate))

    def of(self, topic: str) -> float:
        """Return the maximum rate of a topic [Hz], infinite without a rule."""
        rates = (rate for pattern, rate in self._rates if fnmatch.fnmatchcase(topic, pattern))
        return next(rates, math.inf)


class RateLimit:
    """Rate limit of messages; unlimited by default."""

    def __init__(self) -> None:
        self._rate, self._due = math.inf, -math.inf

    def set_rate(self, rate: float) -> None:
        """Change the rate, from the next message on.

        :param rate: Hz, infinite for all messages
        """
        if rate != self._rate:
            self._rate, self._due = rate, -math.inf

    def passes(self, now: float) -> bool:
        """Return whether a message that arrives now passes.

        A message that is up to a period late does not delay the next: a 30 Hz topic limited to 20
        Hz passes at 20 Hz, not at 15 Hz.

        :param now: monotonic time [s]
        """
        if now < self._due:
            return False
        period = 1.0 / self._rate
        self._due = period + (self._due if now < self._due + period else now)
        return True
