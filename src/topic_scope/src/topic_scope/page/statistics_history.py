# Pure: knows no ROS.
"""Variation of the measurements of traces since a page requested it."""

import math
from typing import Any, Dict, Iterable, Mapping, Tuple

#: What is a number, but no figure.
_NO_FIGURES = ("silent", "nan")


class Variation:
    """Count, mean, standard deviation, least and greatest of numbers that come one by one.

    By the recurrence of Welford (1962), which loses no digits where numbers vary little.
    """

    def __init__(self) -> None:
        self._count = 0
        self._mean = self._squares = 0.0
        self._least, self._greatest = math.inf, -math.inf

    def add(self, number: float) -> None:
        """Add a number."""
        self._count += 1
        away = number - self._mean
        self._mean += away / self._count
        self._squares += away * (number - self._mean)
        self._least, self._greatest = min(self._least, number), max(self._greatest, number)

    @property
    def summary(self) -> Dict[str, float]:
        """Summary of at least one number."""
        return {
            "mean": self._mean,
            "sigma": math.sqrt(self._squares / self._count),
            "min": self._least,
            "max": self._greatest,
            "count": self._count,
        }


class StatisticsHistory:
    """Variation of the measurements of one page.

    A figure counts once for each span of time that it was measured in: on a page that stands still
    nothing is added, nor is what cannot be measured.
    """

    def __init__(self) -> None:
        self._number = 0
        self._span = (math.nan, math.nan)
        self._variations: Dict[str, Dict[str, Variation]] = {}

    def forget(self, names: Iterable[str]) -> None:
        """Drop the history of some traces, whose values have been rescaled."""
        for name in names:
            self._variations.pop(name, None)

    def count(
        self, number: int, span: Tuple[float, float], traces: Mapping[str, Dict[str, Any]]
    ) -> None:
        """Count what was measured, and tell of each trace how its figures have varied.

        :param number: of the request; another number restarts the count, 0 ends it
        :param span: of which time the figures are [s]
        :param traces: what is told of each trace by its name; gets ``over_time``
        """
        if number != self._number:
            self._number, self._span, self._variations = number, (math.nan, math.nan), {}
        if not number:
            return
        is_new, self._span = span != self._span, span
        for name, told in traces.items():
            is_to_count = is_new or name not in self._variations
            variations = self._variations.setdefault(name, {})
            for key, value in told.items() if is_to_count else ():
                if isinstance(value, float) and key not in _NO_FIGURES and math.isfinite(value):
                    variations.setdefault(key, Variation()).add(value)
            told["over_time"] = {key: one.summary for key, one in variations.items()}
