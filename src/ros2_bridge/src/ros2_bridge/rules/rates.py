"""Maximum rates of topics; imports neither ROS."""

import fnmatch
import math
from typing import List, Sequence, Tuple


class MaxRates:
    """The highest rate of each topic.

    :param rules: each ``PATTERN=HZ``, such as ``/camera/*=10``; the first that matches counts
    :raises ValueError: if one is malformed; the text is a clause that says what must hold
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
        """Return the highest rate of a topic in Hz, infinite where no rule says."""
        rates = (rate for pattern, rate in self._rates if fnmatch.fnmatchcase(topic, pattern))
        return next(rates, math.inf)


class RateLimit:
    """Lets messages pass at most so often; all of them, until it is told how often."""

    def __init__(self) -> None:
        self._rate, self._due = math.inf, -math.inf

    def set_rate(self, rate: float) -> None:
        """Change how often, from the next message on.

        :param rate: Hz, infinite for all
        """
        if rate != self._rate:
            self._rate, self._due = rate, -math.inf

    def passes(self, now: float) -> bool:
        """Tell whether a message that has come now passes.

        It may come up to a period late without the next one being late as well: what comes at 30 Hz
        and may pass at 20 Hz passes at 20 Hz, not at every second message.

        :param now: s, on a clock that only goes forward
        """
        if now < self._due:
            return False
        period = 1.0 / self._rate
        self._due = period + (self._due if now < self._due + period else now)
        return True
