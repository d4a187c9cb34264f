# Pure: knows no ROS.
"""Samples of a plant's messages, timed by their field ``time`` if present, else by arrival."""

from typing import Any, List, Optional

import numpy


def stamp_of(message: Any) -> Optional[float]:
    """Return the value of a message's field ``time`` [s]; None if it has no such field.

    :param message: a ROS message
    """
    value = getattr(message, "time", None)
    return float(value) if isinstance(value, float) else None


class Samples:
    """Values with the time of their arrival and, if present, their own time stamp."""

    def __init__(self) -> None:
        self.arrivals: List[float] = []
        self.stamps: List[Optional[float]] = []
        self.values: List[float] = []

    def add(self, arrival: float, stamp: Optional[float], value: float) -> None:
        """Add a sample.

        :param arrival: time of arrival [s]
        :param stamp: the time stamp of the message, if any [s]
        :param value: the value
        """
        self.arrivals.append(arrival)
        self.stamps.append(stamp)
        self.values.append(value)

    def times(self) -> numpy.ndarray:
        """Return the times of measurement [s], by the clock of the arrivals.

        A message may arrive late, so its stamp is more accurate: the message with the least delay
        gives the offset of the plant's clock. Stamps that do not increase are ignored.
        """
        arrivals = numpy.array(self.arrivals, float)
        if None in self.stamps or len(arrivals) < 2:
            return arrivals
        stamps = numpy.array(self.stamps, float)
        if not numpy.isfinite(stamps).all() or numpy.diff(stamps).min() <= 0.0:
            return arrivals
        times: numpy.ndarray = stamps + (arrivals - stamps).min()
        return times
