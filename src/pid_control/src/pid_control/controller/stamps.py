"""The time between measurements, from their stamps, which may be wrong.

A controller that takes its own loop's period for dt integrates wrongly whenever that is late. What
counts is when the plant was measured, and the measurement says so.
"""

from typing import NamedTuple, Optional

#: What a stamp says. FIRST: there is none to compare it with. NEXT: it follows the one before.
#: LATE: not after the one before, so there is nothing new to answer. GAP: measurements were missing
#: for longer than one may wait. RESTART: the plant's time has begun anew.
FIRST, NEXT, LATE, GAP, RESTART = "first", "next", "late", "gap", "restart"

#: How late a message may be that another one has overtaken, s. A plant that was restarted soon
#: after its start is to be told from that, also where one may wait for long.
_LATEST_S = 0.1


class ClassifiedStamp(NamedTuple):
    """What becomes of a measurement.

    :ivar kind: FIRST, NEXT, LATE, GAP or RESTART
    :ivar interval: dt, time since the measurement before, s; 0 but for NEXT
    """

    kind: str
    interval: float


class StampClassifier:
    """Judges the stamps of measurements, one after the other."""

    def __init__(self) -> None:
        self._latest: Optional[float] = None

    def classify(self, stamp: float, longest: float) -> ClassifiedStamp:
        """Judge the stamp of the next measurement.

        :param stamp: when it was made, s, in the plant's time; finite
        :param longest: longest time without one, s. A stamp that is set back by more than that, or
            than a message may be late, is of a plant that was restarted; one that is set back by
            less of a message that came late or twice
        """
        latest = self._latest
        if latest is None:
            kind, interval = FIRST, 0.0
        elif latest - stamp > min(longest, _LATEST_S):
            kind, interval = RESTART, 0.0
        elif stamp <= latest:
            return ClassifiedStamp(LATE, 0.0)
        elif stamp - latest > longest:
            kind, interval = GAP, 0.0
        else:
            kind, interval = NEXT, stamp - latest
        self._latest = stamp
        return ClassifiedStamp(kind, interval)
