# Pure: knows no ROS.
"""Trigger of a page: search for level crossings of a trace."""

import math
from typing import Any, Callable, Dict, Optional, Tuple

import numpy

from topic_scope.analysis.ring import Samples
from topic_scope.protocol.requests import Trigger

#: Time after the last crossing until the trigger is reported as waiting [s].
_QUIET_S = 0.5
#: Least time that the mode auto holds the last crossing, so that slow signals do not flicker [s].
_AUTO_S = 1.5
#: Least time between reported crossings [s].
_SHORTEST_S = 1.0 / 30.0


def crossings(
    times: numpy.ndarray,
    values: numpy.ndarray,
    level: float,
    rising: bool,
    hysteresis: float = 0.0,
    longest: float = math.inf,
) -> numpy.ndarray:
    """Return the times at which a trace crosses a level, interpolated between samples.

    In a gap, the level is crossed at the second sample.

    :param times: ascending [s]
    :param values: the samples; non-finite values are ignored
    :param level: the level; a sample on it has arrived on the far side
    :param rising: whether the level is crossed upwards
    :param hysteresis: distance on the near side that the trace must reach before a crossing
    :param longest: longest time between connected samples [s]
    :returns: the times [s]
    """
    return _crossings(times, values, level, rising, hysteresis, longest, False)[0]


def _crossings(
    times: numpy.ndarray,
    values: numpy.ndarray,
    level: float,
    rising: bool,
    hysteresis: float,
    longest: float,
    is_ready: bool,
) -> Tuple[numpy.ndarray, bool]:
    """Return crossings, and whether the next one counts.

    :param is_ready: whether the trace has been far enough on the near side before
    """
    finite = numpy.isfinite(values)
    times, values = times[finite], values[finite]
    with numpy.errstate(over="ignore"):
        height = (values - level) if rising else (level - values)
    side = (height >= 0).astype(numpy.int8) - ((height < 0) & (height <= -hysteresis))
    sure = numpy.flatnonzero(side)
    before = numpy.concatenate([[-1 if is_ready else 1], side[sure]])
    arrived = sure[(before[:-1] < 0) & (before[1:] > 0)]
    arrived = arrived[arrived > 0]
    # Halved, so that a step over the full range of floats does not overflow.
    low, high = height[arrived - 1] / 2, height[arrived] / 2
    apart = times[arrived] - times[arrived - 1]
    part = numpy.where(apart > longest, 1.0, low / (low - high))
    moments = times[arrived - 1] + part * apart
    return moments, bool(before[-1] < 0)


class TriggerWatch:
    """Trigger of one page.

    In the modes normal and auto it reports a crossing, waits until the page has shown it, and then
    searches for the next. In the mode single it reports the first crossing only.

    :param request: the requested trigger
    :param now: only later crossings count [s]

    :ivar request: the requested trigger
    """

    def __init__(self, request: Trigger, now: float) -> None:
        self.request = request
        self._seen = now
        self._hold_until = now
        self._found_at = now
        self._is_ready = False
        self._state = "off" if request.mode == "off" else "armed"
        self._time: Optional[float] = None
        self._sent: Optional[Dict[str, Any]] = None

    def update(
        self,
        now: float,
        window: float,
        source: Callable[[str, float, float], Samples],
        longest_step: Callable[[str], float] = lambda _field: math.inf,
    ) -> Optional[Dict[str, Any]]:
        """Search new samples for crossings.

        :param now: time up to which samples are complete [s]
        :param window: time span of the page [s]
        :param source: reader of the samples
        :param longest_step: returns the longest time between connected samples [s]
        :returns: the message for the page; None if it has not changed
        """
        if self._is_waiting:
            field = self.request.field
            if self._search(source(field, self._seen, now), longest_step(field), window):
                self._found_at = now
            if self._state == "triggered" and self.request.mode != "single":
                is_auto = self.request.mode == "auto"
                shown_until = max(self._hold_until, self._found_at)  # it may have been found late
                if now > shown_until + (max(window, _AUTO_S) if is_auto else _QUIET_S):
                    self._state, self._time = "armed", None
        message = {
            "type": "trigger",
            "number": self.request.number,
            "state": self._state,
            "time": self._time,
        }
        if message == self._sent:
            return None
        self._sent = message
        return message

    @property
    def _is_waiting(self) -> bool:
        return self.request.mode in ("normal", "auto") or self._state == "armed"

    def _search(self, samples: Samples, longest: float, window: float) -> bool:
        """Return whether there is a valid crossing."""
        times, values = samples
        if not len(times):
            return False
        self._seen = float(times[-1])  # read again next time, as the sample before the first
        wanted = self.request
        how = (wanted.level, wanted.rising, wanted.hysteresis, longest, self._is_ready)
        found, self._is_ready = _crossings(times, values, *how)
        found = found[found > self._hold_until]
        if len(found):
            self._state, self._time = "triggered", float(found[0])
            after = window * (1.0 - wanted.position)
            self._hold_until = self._time + max(after, wanted.holdoff, _SHORTEST_S)
        return len(found) > 0
