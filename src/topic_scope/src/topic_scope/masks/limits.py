"""Mask: limits around a reference trace, by a distance in value and in time.

The limits are formulas, so they are drawn and saved as all traces are; and one formula says of each
sample by how much it is outside.
"""

import math
from typing import NamedTuple, Optional, Protocol, Tuple

import numpy

from topic_scope.analysis.ring import Samples
from topic_scope.formulas.names import problem_of, with_letters
from topic_scope.messages.fields import FieldError
from topic_scope.sampling.computed_trace import ComputedTrace, Recorded


#: A reference has ended where it was silent for longer than this at least [s].
_ENDED_S = 0.5
_NOTHING: Samples = (numpy.empty(0), numpy.empty(0))


class Mask(NamedTuple):
    """Limits that a trace must keep within.

    :param field: name of the trace
    :param reference: name of the trace that the limits are around
    :param value: how far above and below it they are
    :param time: how far before and after it [s]
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
            told = map(problem_of, (self.field, self.reference, self.excess))
            return next((text for text in told if text), None)
        except FieldError as error:  # the formula cannot even be put together
            return str(error)

    @property
    def names(self) -> Tuple[str, ...]:
        """Names of all traces to record for it."""
        return self.field, self.reference, self.upper, self.lower, self.excess


class Verdict(NamedTuple):
    """Result so far.

    :param inside: how many samples were within the limits
    :param outside: how many were not
    :param unchecked: how many could not be checked, as the reference was not known there
    :param first: when the first one outside was taken [s]; None without one
    :param worst: by how much the worst one was outside
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
        """Return what is recorded of a name; None where nothing is."""

    def samples(self, name: str, start: float, end: float) -> Samples:
        """Return the samples of a name from one time to another [s]."""

    def longest_step(self, name: str) -> float:
        """Return how far apart samples of one line of a name may be [s]."""


class MaskCheck:
    """Checks each sample of a trace once, as soon as its reference is known.

    :param mask: what it has to keep within
    :param start: samples that were taken later than this are checked [s]

    :ivar mask: what it has to keep within
    :ivar verdict: what has come out so far
    """

    def __init__(self, mask: Mask, start: float) -> None:
        self.mask = mask
        self.verdict = Verdict()
        self._checked_until = start
        self._excess = mask.excess

    def update(self, samplers: SampleReader) -> Verdict:
        """Check the new samples.

        :returns: what has come out so far
        """
        trace = samplers.trace(self._excess)
        if trace is None:
            return self.verdict
        # What counts for samples before that was forgotten: they will never be checked.
        before = float(numpy.nextafter(trace.whole_from, -math.inf))
        lost = self._new(samplers, self.mask.field, before)[0]
        self._count(lost, numpy.full(len(lost), math.nan))
        age = trace.age(0.0)
        if age is not None:
            self._count(*self._new(samplers, self._excess, -age))
        return self.verdict

    def finish(self, samplers: SampleReader) -> Optional[float]:
        """Count the remaining samples as unchecked, at the end.

        :returns: how long before the trace the reference has ended [s]; None where it has not, or
            where all are checked
        """
        left = len(self._new(samplers, self.mask.field, math.inf)[0])
        self.verdict = self.verdict._replace(unchecked=self.verdict.unchecked + left)
        return self.ended(samplers) if left else None

    def words(self, samplers: SampleReader) -> str:
        """Return the result as text, with the reason if no further samples can be checked."""
        ended, text = self.ended(samplers), self.verdict.text
        trace = samplers.trace(self._excess)
        if isinstance(trace, ComputedTrace) and trace.problem:
            text = f"{text}; {trace.problem}"
        return text if ended is None else f"{text}; {self.mask.reference} silent for {ended:.1f} s"

    def ended(self, samplers: SampleReader) -> Optional[float]:
        """Return how long before the trace the reference has ended [s]; None if it has not."""
        traces = [samplers.trace(name) for name in (self.mask.field, self.mask.reference)]
        # By reception: what has stamps that are late, or is delayed, has not ended.
        quiet = [one.silence(0.0) for one in traces if one is not None]
        if len(quiet) < 2 or quiet[0] is None or quiet[1] is None:
            return None
        ended, longest = quiet[1] - quiet[0], samplers.longest_step(self.mask.reference)
        usual = max(longest if math.isfinite(longest) else 0.0, _ENDED_S)
        return ended if ended > usual else None

    def _new(self, samplers: SampleReader, name: str, end: float) -> Samples:
        """Return the samples of a name after those already checked, up to a time [s]."""
        begin = float(numpy.nextafter(self._checked_until, math.inf))
        return samplers.samples(name, begin, end) if begin <= end else _NOTHING

    def _count(self, times: numpy.ndarray, excess: numpy.ndarray) -> None:
        """Count samples by their excess; NaN for those that cannot be checked."""
        self._checked_until = float(times.max(initial=self._checked_until))
        outside = numpy.flatnonzero(excess > 0.0)
        unknown = int(numpy.isnan(excess).sum())
        before = self.verdict
        first = float(times[outside[0]]) if len(outside) else None
        self.verdict = Verdict(
            before.inside + len(times) - len(outside) - unknown,
            before.outside + len(outside),
            before.unchecked + unknown,
            before.first if before.first is not None else first,
            max(before.worst, float(excess[outside].max(initial=0.0))),
        )
