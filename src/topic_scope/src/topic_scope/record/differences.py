"""The difference of two traces, such as ``/signal/signal_y-/proc_signal/data``.

It has a value at each sample of the first trace, less the second one on the straight line between
two of its samples; so it ends where either of both has ended so far, and follows when more comes.
"""

import math
from typing import Collection, Dict, List, Mapping, Optional, Tuple

import numpy

from topic_scope.analysis.ring import Samples
from topic_scope.analysis.xy import paired
from topic_scope.messages import fields
from topic_scope.messages.derived import terms
from topic_scope.record.recorder import Recorder
from topic_scope.record.traces import Recorded, Timed

Span = Tuple[float, float]


class Difference:
    """One trace less another one; to be asked as a trace is.

    :param first: the one
    :param second: the other one
    """

    def __init__(self, first: Recorded, second: Recorded) -> None:
        self._first, self._second = first, second

    @property
    def stream(self) -> Timed:
        """What gives the first trace its topic and its time."""
        return self._first.stream

    def samples(self, start: float, end: float) -> Samples:
        """Return times and values of a time span, its ends included, s."""
        times, values = self._first.samples(start, end)
        known = times <= self._until
        times, values = times[known], values[known]
        longest = self._second.longest_step
        others = self._second.samples(start - longest, end + longest)
        less, _ = paired(others, (times, values), longest)
        return times, values - less

    def received(self, start: float, end: float) -> numpy.ndarray:
        """Return when the samples of a time span were received, s: those of the first trace."""
        times, _ = self._first.samples(start, end)
        return self._first.received(start, end)[times <= self._until]

    @property
    def span(self) -> Optional[Span]:
        """The times of the first and the last sample, s; None where there is none."""
        first, second = self._first.span, self._second.span
        if first is None or second is None or first[0] > second[1]:
            return None
        return first[0], min(first[1], second[1])

    @property
    def longest_step(self) -> float:
        """How far apart samples of one line may be, s."""
        return self._first.longest_step

    def age(self, now: float) -> Optional[float]:
        """Return how long ago the last sample was taken, s; None where there is none."""
        ages = self._first.age(now), self._second.age(now)
        return None if None in ages else max(age for age in ages if age is not None)

    @property
    def _until(self) -> float:
        """When the latest sample of the second trace was taken, s."""
        age = self._second.age(0.0)
        return -math.inf if age is None else -age


class DifferenceRecorder(Recorder):
    """A recorder that has differences, too; they are made of what is recorded when asked for."""

    #: Up to when the differences that are looked at were known at the latest update, s.
    _known: Dict[str, float] = {}

    def expand(self, name: str) -> List[str]:
        """Return the names of all fields that a name stands for; see :meth:`.Recorder.expand`."""
        parts = terms(name)
        if len(parts) == 1:
            return super().expand(name)
        return [
            fields.difference_of([super(DifferenceRecorder, self).expand(part) for part in parts])
        ]

    def want(self, names: Collection[str], now: float) -> None:
        """Record these fields, and those that differences are of."""
        super().want({part for name in names for part in terms(name)}, now)
        self._known = {
            name: self._known.get(name, -math.inf) for name in names if len(terms(name)) > 1
        }

    def pin(self, spans: Mapping[str, Span]) -> None:
        """Keep the samples of fields for as long as these spans are named."""
        wanted: Dict[str, Span] = {}
        for name, (start, end) in spans.items():
            parts = terms(name)
            for part in parts:
                # What lies between two samples needs both.
                more = super().longest_step(part) if len(parts) > 1 else 0.0
                before = wanted.get(part, (start, end))
                wanted[part] = min(start - more, before[0]), max(end + more, before[1])
        super().pin(wanted)

    def update(self) -> float:
        """Take in what has come; see :meth:`.Recorder.update`."""
        now = super().update()
        for name, known in self._known.items():
            trace = self.trace(name)
            age = trace.age(now) if trace is not None else None
            if age is not None and now - age > known:
                # What was there of the first trace is known only now.
                self._updates[-1] = now, min(self._updates[-1][1], known)
                self._known[name] = now - age
        return now

    def forget(self) -> None:
        """Forget all samples: those that come next are of another time."""
        super().forget()
        self._known = dict.fromkeys(self._known, -math.inf)

    def samples(self, name: str, start: float, end: float) -> Samples:
        """Return the samples of a field, or of a difference; see :meth:`.Recorder.samples`."""
        if len(terms(name)) == 1:
            return super().samples(name, start, end)
        trace = self.trace(name)
        return trace.samples(start, end) if trace else (numpy.empty(0), numpy.empty(0))

    def longest_step(self, name: str) -> float:
        """Return how far apart samples of one line may be, s."""
        return super().longest_step(terms(name)[0])

    def problem(self, name: str) -> Optional[str]:
        """Return why there is nothing of a field or of a difference; None if nothing is known."""
        parts = terms(name)
        if len(parts) == 1:
            return super().problem(name)
        told = [(part, super(DifferenceRecorder, self).problem(part)) for part in parts]
        return next((f"{part}: {text}" for part, text in told if text), None)

    def trace(self, name: str) -> Optional[Recorded]:
        """Return what is recorded of a field, or of a difference; None where nothing is."""
        found = [super(DifferenceRecorder, self).trace(part) for part in terms(name)]
        if len(found) == 1:
            return found[0]
        first, second = found
        return Difference(first, second) if first and second else None
