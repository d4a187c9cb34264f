# Pure: knows no ROS.
"""Samples of outputs, by the plant's own time where they carry it. Pure."""

from typing import Any, List, Optional

import numpy


def stamp_of(message: Any) -> Optional[float]:
    """Return the time that a message carries in a field of that name, s; None where it has none.

    :param message: of ROS
    """
    value = getattr(message, "time", None)
    return float(value) if isinstance(value, float) else None


class Samples:
    """Values, each with the time at which it was heard and, maybe, the one that it carries."""

    def __init__(self) -> None:
        self.heard: List[float] = []
        self.stamps: List[Optional[float]] = []
        self.values: List[float] = []

    def add(self, heard: float, stamp: Optional[float], value: float) -> None:
        """Add one.

        :param heard: when it was heard, s
        :param stamp: what it says of its time, s
        :param value: the number
        """
        self.heard.append(heard)
        self.stamps.append(stamp)
        self.values.append(value)

    def times(self) -> numpy.ndarray:
        """Return when they were measured, by the clock by which they were heard, s.

        A message may be heard late, and then its stamp knows better: the one that was least late
        tells how the plant's clock differs. Stamps that do not increase are not gone by.
        """
        heard = numpy.array(self.heard, float)
        if None in self.stamps or len(heard) < 2:
            return heard
        stamps = numpy.array(self.stamps, float)
        if not numpy.isfinite(stamps).all() or numpy.diff(stamps).min() <= 0.0:
            return heard
        times: numpy.ndarray = stamps + (heard - stamps).min()
        return times
