"""Find the moments at which a trace crosses a level, and tell a page of them."""

from typing import Any, Callable, Dict, Optional

import numpy

from topic_scope import protocol
from topic_scope.ring import Samples

#: How long after the last crossing it is said that none comes, s.
_QUIET_S = 0.5
#: Least time from one crossing to the next that is told, s.
_SHORTEST_S = 1.0 / 30.0


def crossings(
    times: numpy.ndarray, values: numpy.ndarray, level: float, rising: bool
) -> numpy.ndarray:
    """Return when a trace crosses a level, on the straight line between two samples.

    :param times: ascending, s
    :param values: the samples; what is not finite is left out
    :param level: the level; a sample on it has arrived on the far side
    :param rising: whether it is crossed upwards
    :returns: the moments, s
    """
    finite = numpy.isfinite(values)
    times, values = times[finite], values[finite]
    height = (values - level) if rising else (level - values)
    before = numpy.flatnonzero((height[:-1] < 0) & (height[1:] >= 0))
    # Halved, so that a step from one end of the range of floats to the other does not overflow.
    low, high = height[before] / 2, height[before + 1] / 2
    part = low / (low - high)
    moments: numpy.ndarray = times[before] + part * (times[before + 1] - times[before])
    return moments


class TriggerWatch:
    """Waits for crossings on behalf of a page.

    In the normal mode it tells of one, lets the page show it in the middle of its span of time, and
    waits for the next. In the mode single it tells of the first only.

    :param request: what to wait for
    :param now: the time from which on it counts, s
    """

    def __init__(self, request: protocol.Trigger, now: float) -> None:
        self._request = request
        self._seen = now
        self._hold_until = now
        self._state = "off" if request.mode == "off" else "armed"
        self._time: Optional[float] = None
        self._told: Optional[Dict[str, Any]] = None

    def update(
        self, now: float, window: float, source: Callable[[str, float, float], Samples]
    ) -> Optional[Dict[str, Any]]:
        """Look at what has come.

        :param now: time up to which all samples are there, s
        :param window: span of time that the page shows, s
        :param source: where the samples are
        :returns: what to tell the page, None if it knows that
        """
        if self._is_waiting:
            self._look(source(self._request.field, self._seen, now), window)
            if self._state == "triggered" and self._request.mode == "normal":
                if now > self._hold_until + _QUIET_S:
                    self._state, self._time = "armed", None
        message = {
            "type": "trigger",
            "number": self._request.number,
            "state": self._state,
            "time": self._time,
        }
        if message == self._told:
            return None
        self._told = message
        return message

    @property
    def _is_waiting(self) -> bool:
        return self._request.mode == "normal" or self._state == "armed"

    def _look(self, samples: Samples, window: float) -> None:
        times, values = samples
        if not len(times):
            return
        self._seen = float(times[-1])  # again with the next look, as the one before its first
        found = crossings(times, values, self._request.level, self._request.rising)
        found = found[found > self._hold_until]
        if len(found):
            self._state, self._time = "triggered", float(found[0])
            self._hold_until = self._time + max(window / 2, _SHORTEST_S)
