"""Classifier of measurement stamps: interval dt, late messages, gaps and restarts.

A controller that uses its loop period as dt integrates wrongly when the loop is late; the stamp of
a measurement is the time at which the plant was measured.
"""

from typing import NamedTuple, Optional

#: Classes of stamps. FIRST: no previous stamp. NEXT: follows the previous one. LATE: not after the
#: previous one, so the measurement is not new. GAP: measurements were missing for longer than the
#: timeout. RESTART: the plant's time started again.
FIRST, NEXT, LATE, GAP, RESTART = "first", "next", "late", "gap", "restart"

#: Largest delay of an overtaken message [s]: it distinguishes a late message from a restart soon
#: after the plant's start, also with a long timeout.
_LATEST_S = 0.1


class ClassifiedStamp(NamedTuple):
    """The class of a stamp, and the interval before it.

    :ivar kind: FIRST, NEXT, LATE, GAP or RESTART
    :ivar interval: dt, time since the previous measurement; 0 except for NEXT [s]
    """

    kind: str
    interval: float


class StampClassifier:
    """Classifier of consecutive measurement stamps."""

    def __init__(self) -> None:
        self._latest: Optional[float] = None

    def classify(self, stamp: float, longest: float) -> ClassifiedStamp:
        """Classify the stamp of the next measurement.

        :param stamp: time of the measurement in the plant's time, finite [s]
        :param longest: longest time without a measurement [s]. A stamp that goes back by more than
            that, or by more than a message may be late, means a restarted plant; by less, a late or
            repeated message
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
