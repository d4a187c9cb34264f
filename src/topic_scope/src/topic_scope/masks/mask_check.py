"""Mask test: limits around a reference trace, and the check of each sample against them.

The limits are formulas, so they are drawn and saved like all traces; another formula computes the
excess of each sample over the limits.
"""

import math
from typing import NamedTuple, Optional, Protocol, Tuple

import numpy

from topic_scope.analysis.ring import LIMIT
from topic_scope.formulas.names import problem_of, with_letters
from topic_scope.messages.fields import FieldError
from topic_scope.sampling.computed_trace import ComputedTrace, Recorded
from topic_scope.sampling.traces import Trace
from topic_scope.timing.nanoseconds import NS, shifted, to_ns


#: Least silence after which a reference has ended [s].
_ENDED_S = 0.5
#: Larger than any rounding of a time since the epoch [s].
_MORE_S = 1e-5


class Mask(NamedTuple):
    """Limits that a trace must keep within.

    :param field: name of the trace
    :param reference: name of the trace at the centre of the limits
    :param value: distance of the limits above and below it
    :param time: distance before and after it [s]
    """

    field: str
    reference: str
    value: float
    time: float

    @property
    def upper(self) -> str:
        """Name of the upper limit, as a trace."""
        return with_letters(f"=highest(a, {self.time!r}) + {self.value!r}", [self.reference])

    @property
    def lower(self) -> str:
        """Name of the lower limit, as a trace."""
        return with_letters(f"=lowest(a, {self.time!r}) - {self.value!r}", [self.reference])

    @property
    def excess(self) -> str:
        """Name of the trace of the excess over the limits, below 0 for samples inside."""
        above = f"a - highest(b, {self.time!r}) - {self.value!r}"
        below = f"lowest(b, {self.time!r}) - {self.value!r} - a"
        return with_letters(f"=max({above}, {below})", [self.field, self.reference])

    @property
    def problem(self) -> Optional[str]:
        """Reason why the mask cannot be checked; None for a valid mask."""
        try:
            problems = map(problem_of, (self.field, self.reference, self.excess))
            return next((text for text in problems if text), None)
        except FieldError as error:  # the formula cannot be built
            return str(error)

    @property
    def names(self) -> Tuple[str, ...]:
        """Names of all traces to record for the mask."""
        return self.field, self.reference, self.upper, self.lower, self.excess


class MaskResult(NamedTuple):
    """Result so far.

    :param inside: number of samples within the limits
    :param outside: number of samples outside
    :param unchecked: number of samples for which the reference is unknown
    :param first: time of the first sample outside [s]; None without one
    :param worst: largest excess
    """

    inside: int = 0
    outside: int = 0
    unchecked: int = 0
    first: Optional[float] = None
    worst: float = 0.0

    @property
    def text(self) -> str:
        """Result as text."""
        words = f"{self.inside} samples inside, {self.outside} outside"
        return f"{words}, {self.unchecked} not checked" if self.unchecked else words


class SampleReader(Protocol):
    """Reader of the samples of traces, such as a recorder."""

    def trace(self, name: str) -> Optional[Recorded]:
        """Return the recorded trace of a name; None if it is not recorded."""

    @property
    def updated(self) -> float:
        """Time of the latest update [s]."""

    def changed_since(self, moment: float) -> float:
        """Return the time from which on samples may have changed [s]."""

    def longest_step(self, name: str) -> float:
        """Return the longest time between connected samples of a name [s]."""


class MaskCheck:
    """Check of each sample of a trace, as soon as its reference is known.

    Each received sample, even a late one, is counted once: as inside, as outside or as not
    checked.

    :param mask: the limits
    :param start: only samples received later are checked [s]

    :ivar mask: the limits
    :ivar result: result so far
    :ivar received: number of received samples
    """

    def __init__(self, mask: Mask, start: float) -> None:
        self.mask = mask
        self.result = MaskResult()
        self.received = 0
        self._start = to_ns(start)
        self._excess = mask.excess
        self._updated = -math.inf
        #: Receipt times of samples that are counted, or wait for their reference [ns]: unique in
        #: a topic.
        self._seen = self._open = numpy.empty(0, numpy.int64)
        self._open_from = to_ns(math.inf)

    def start(self, moment: float) -> None:
        """Check only samples that are received from now on.

        :param moment: the time [s]
        """
        self._start = to_ns(moment)

    def update(self, samplers: SampleReader) -> MaskResult:
        """Check the new samples, and those whose reference is known now.

        :returns: result so far
        """
        field, excess = samplers.trace(self.mask.field), samplers.trace(self._excess)
        if field is None or excess is None:
            return self.result
        changed, self._updated = samplers.changed_since(self._updated), samplers.updated
        begin = min(to_ns(changed - _MORE_S), self._open_from)
        times, values, received = field.rows(begin, to_ns(math.inf))
        # At the end of a line the last sample is repeated, without a value.
        real = numpy.append(True, received[1:] != received[:-1])[: len(times)]
        real |= ~numpy.isnan(values)
        times, received = times[real], received[real]
        is_new = (received > self._start) & ~_among(received, self._seen)
        is_open = is_new | _among(received, self._open)
        self.received += int(is_new.sum())
        if type(field) is Trace:  # its samples appear in the order of receipt
            self._start = max(self._start, int(received.max(initial=self._start)))
        else:
            self._seen = numpy.sort(numpy.append(self._seen, received[is_new]))[-LIMIT:]
        self._count(excess, times[is_open], received[is_open])
        return self.result

    def _count(self, excess: Recorded, times: numpy.ndarray, received: numpy.ndarray) -> None:
        """Count the uncounted samples whose excess is known.

        :param times: times of all uncounted samples in memory [ns]
        :param received: their receipt times [ns]
        """
        before = self.result
        span = int(times.min(initial=0)), int(times.max(initial=0))
        _, values, found = excess.rows(*span)
        order = found.argsort(kind="stable")
        is_known = _among(received, found[order])
        by = numpy.full(len(times), math.nan)
        by[is_known] = values[order][found[order].searchsorted(received[is_known])]
        # The reference of earlier samples was dropped: they will never be checked.
        is_lost = ~is_known & (times <= excess.whole_from)
        is_open = ~is_known & ~is_lost
        outside = (by > 0.0).nonzero()[0]
        inside = int((by <= 0.0).sum())
        first = float(times[outside].min()) / NS if len(outside) else math.inf
        if before.first is not None:
            first = min(first, before.first)
        self._open = numpy.sort(received[is_open])
        self._open_from = shifted(int(times[is_open].min(initial=to_ns(math.inf))), -NS)
        counted = before.inside + inside + before.outside + len(outside)
        self.result = MaskResult(
            before.inside + inside,
            before.outside + len(outside),
            self.received - counted - len(self._open),
            first if math.isfinite(first) else None,
            max(before.worst, float(by[outside].max(initial=0.0))),
        )

    def finish(self, samplers: SampleReader) -> Optional[float]:
        """Count the remaining samples as unchecked, at the end.

        :returns: how long before the trace the reference ended [s]; None if it has not ended, or
            if all samples are checked
        """
        left = len(self._open)
        self.result = self.result._replace(unchecked=self.result.unchecked + left)
        assert sum(self.result[:3]) == self.received, "a sample is counted twice, or not at all"
        return self.ended(samplers) if left else None

    def words(self, samplers: SampleReader) -> str:
        """Return the result as text, with the reason if no further samples can be checked."""
        ended, text = self.ended(samplers), self.result.text
        trace = samplers.trace(self._excess)
        if isinstance(trace, ComputedTrace) and trace.problem:
            text = f"{text}; {trace.problem}"
        return text if ended is None else f"{text}; {self.mask.reference} silent for {ended:.1f} s"

    def ended(self, samplers: SampleReader) -> Optional[float]:
        """Return how long before the trace the reference ended [s]; None if it has not."""
        traces = [samplers.trace(name) for name in (self.mask.field, self.mask.reference)]
        # By receipt: a trace with late stamps, or a delayed trace, has not ended.
        quiet = [one.silence(0.0) for one in traces if one is not None]
        if len(quiet) < 2 or quiet[0] is None or quiet[1] is None:
            return None
        ended, longest = quiet[1] - quiet[0], samplers.longest_step(self.mask.reference)
        usual = max(longest if math.isfinite(longest) else 0.0, _ENDED_S)
        return ended if ended > usual else None


def _among(values: numpy.ndarray, known: numpy.ndarray) -> numpy.ndarray:
    """Return a mask of the values that are in a sorted array."""
    places = known.searchsorted(values)
    is_known: numpy.ndarray = places < len(known)
    is_known[is_known] = known[places[is_known]] == values[is_known]
    return is_known
