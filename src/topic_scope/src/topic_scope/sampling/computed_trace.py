# Pure: knows no ROS.
"""Traces that are computed from others by a formula."""

import math
from typing import Mapping, Optional, Tuple, Union

import numpy

from topic_scope.analysis.ring import Rows, Samples
from topic_scope.formulas.expression import Operands
from topic_scope.formulas.parser import Formula
from topic_scope.formulas.signals import Signal
from topic_scope.messages import field_functions
from topic_scope.sampling.traces import JUMPS, Stream, Trace
from topic_scope.timing.nanoseconds import NS, ROUNDED_NS, shifted, to_ns, to_seconds


class ComputedTrace:
    """Trace computed from others, with the interface of a recorded trace.

    It has a value at each sample of the first trace, with the others interpolated linearly between
    their samples; so it ends where the shortest of them ends so far, and continues when more
    arrives. No value is computed if required samples were dropped.

    :param formula: its formula
    :param traces: its operands, by the names in the formula
    """

    def __init__(self, formula: Formula, traces: Mapping[str, Trace]) -> None:
        self._tree = formula.tree
        functions = [token.text for token in formula.tokens if token.kind != "field"]
        self._is_derivative = field_functions.DERIVATIVE in functions
        self._traces = [traces[name] for name in formula.fields]
        self._first = self._traces[0]
        self._operands = Operands(
            lambda name, start, end: traces[name].signal(start, end),
            lambda name: traces[name].longest_step,
            lambda name: traces[name].last,
        )

    @property
    def states(self) -> None:
        """None: a formula computes numbers."""
        return None

    @property
    def stream(self) -> Stream:
        """Stream of the first trace."""
        return self._first.stream

    @property
    def correction(self) -> Optional[str]:
        """Correction of the stamps and values of an operand, as text."""
        return next((trace.correction for trace in self._traces if trace.correction), None)

    @property
    def jumps(self) -> Optional[str]:
        """Why the trace may jump, as text; None if it does not."""
        by_receipt = any(trace.stream.path is None for trace in self._traces)
        if self._is_derivative and by_receipt:
            return JUMPS
        return next((trace.jumps for trace in self._traces if trace.jumps), None)

    def samples(self, start: float, end: float) -> Samples:
        """Return times and values of a time span, its ends included [s]."""
        signal = self.signal(to_ns(start) - ROUNDED_NS, to_ns(end) + ROUNDED_NS)
        return signal.times / NS, signal.values

    def rows(self, start: int, end: int) -> Rows:
        """Return the samples of a time span, its ends included [ns]."""
        times, values, received, _ = self.signal(start, end)
        return times, values, received

    def signal(self, start: int, end: int) -> Signal:
        """Return the samples of a time span [ns]."""
        found = self._tree.signal(self._operands, start, end)
        return found.between(max(start, self.whole_from), min(end, self.last))

    def latency(self, start: float, end: float) -> numpy.ndarray:
        """Return the latencies of the first trace, from stamp to receipt [s]."""
        return self._first.latency(start, end)

    @property
    def span(self) -> Optional[Tuple[float, float]]:
        """Time span that may contain samples [s]; None without samples."""
        span = self._first.span
        if span is None:
            return None
        begin = span[0] + min(self.lookaround[0], 0.0)
        first, until = max(begin, to_seconds(self.whole_from)), self.until
        return (first, until) if first <= until else None

    @property
    def longest_step(self) -> float:
        """Longest time between connected samples [s]."""
        return self._first.longest_step

    @property
    def until(self) -> float:
        """Time up to which it is known [s]; minus infinity if it is unknown."""
        return to_seconds(self.last)

    @property
    def last(self) -> int:
        """The same [ns]; the earliest time if it is unknown."""
        return self._tree.until(self._operands)

    @property
    def lookaround(self) -> Tuple[float, float]:
        """Time span of samples before and after a value that affect it [s]."""
        return self._tree.lookaround(self._operands)

    @property
    def problem(self) -> Optional[str]:
        """Why the trace cannot have samples, as text; None if it can."""
        kept = min(trace.ring.history for trace in self._traces)
        back, ahead = self._back, self._ahead
        if back + ahead <= kept:
            return None
        needed = f"the last {back:g} s"
        if ahead:
            needed = f"{back:g} s before and {ahead:g} s after each"
        return f"it needs {needed}, and samples are kept for {kept:g} s (--history)"

    @property
    def whole_from(self) -> int:
        """Time from which on all required samples are in memory [ns]."""
        return shifted(max(trace.whole_from for trace in self._traces), to_ns(self._back))

    @property
    def _back(self) -> float:
        """Time span of samples before a value that affect it [s]; 0 if unknown."""
        back = self.lookaround[0]
        return max(back, 0.0) if math.isfinite(back) else 0.0

    @property
    def _ahead(self) -> float:
        """Delay after which a value is known [s]; 0 if unknown."""
        ahead = to_seconds(min(trace.last for trace in self._traces)) - self.until
        return max(ahead, 0.0) if math.isfinite(ahead) else 0.0

    def silence(self, now: float) -> Optional[float]:
        """Return the time since the last receipt of the quietest operand [s]; None if unknown."""
        quiet = [trace.silence(now) for trace in self._traces]
        return None if None in quiet else max(one for one in quiet if one is not None)


#: Recorded or computed trace.
Recorded = Union[Trace, ComputedTrace]
