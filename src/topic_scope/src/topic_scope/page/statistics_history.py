# Pure: knows no ROS.
"""Running mean, deviation, minimum and maximum of each measurement on one page."""

import math
from typing import Any, Dict, Iterable, Mapping, Tuple

#: Numbers in the table that are not measurements.
_NO_FIGURES = ("silent", "nan")


class Variation:
    """Running count, mean, standard deviation, minimum and maximum.

    Uses the recurrence of Welford (1962), which loses no digits if numbers vary little.
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
    """Statistics over time of the measurements of one page.

    A measurement counts once for each time span: on a paused page nothing is added, nor is a
    quantity that cannot be measured.
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
        """Add measurements, and add the statistics over time to each trace.

        :param number: number of the request; another number restarts the count, 0 ends it
        :param span: time span of the measurements [s]
        :param traces: measurements of each trace by name; ``over_time`` is added
        """
        if number != self._number:
            self._number, self._span, self._variations = number, (math.nan, math.nan), {}
        if not number:
            return
        is_new, self._span = span != self._span, span
        for name, figures in traces.items():
            is_to_count = is_new or name not in self._variations
            variations = self._variations.setdefault(name, {})
            for key, value in figures.items() if is_to_count else ():
                if isinstance(value, float) and key not in _NO_FIGURES and math.isfinite(value):
                    variations.setdefault(key, Variation()).add(value)
            figures["over_time"] = {key: one.summary for key, one in variations.items()}
