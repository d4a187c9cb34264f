"""Expression tree of a validated formula."""

import math
from typing import Callable, List, Mapping, NamedTuple, Sequence, Tuple, Union

import numpy

from topic_scope.formulas.signals import (
    SETTLED,
    Signal,
    averaged,
    delayed,
    extreme,
    low_passed,
    slope,
)
from topic_scope.timing.nanoseconds import shifted, to_ns


class Operands(NamedTuple):
    """Access to the samples of a formula's fields, by name.

    :param read: returns the samples from one time to another [ns]
    :param longest_step: returns the longest time between connected samples [s]
    :param last: returns the time of the last sample [ns]; the earliest time if there are no samples
    """

    read: Callable[[str, int, int], Signal]
    longest_step: Callable[[str], float]
    last: Callable[[str], int]

    @classmethod
    def of(cls, signals: Mapping[str, Signal]) -> "Operands":
        """Return access to complete signals, by name."""
        return cls(
            lambda name, start, end: signals[name].between(start, end),
            lambda name: signals[name].longest,
            lambda name: int(signals[name].times.max(initial=to_ns(-math.inf))),
        )


class Number(NamedTuple):
    """Constant of a formula, or a value computed from constants."""

    value: float


class _Sampled:
    """Node of the tree with samples of its own, unlike :class:`Elementwise`."""

    fields: List[str]

    def signal(self, operands: Operands, start: int, end: int) -> Signal:
        """Return the samples of a time span [ns], or some more."""
        raise NotImplementedError

    def at(self, operands: Operands, times: numpy.ndarray, start: int, end: int) -> numpy.ndarray:
        """Return the values at some times of a time span [ns], interpolated between samples."""
        more = to_ns(operands.longest_step(self.fields[0]))
        return self.signal(operands, shifted(start, -more), shifted(end, more)).at(times)


class Field(_Sampled):
    """Recorded trace.

    :param name: its name
    """

    def __init__(self, name: str) -> None:
        self.name = name
        #: Its fields; the stamps of the first are used.
        self.fields = [name]

    def signal(self, operands: Operands, start: int, end: int) -> Signal:
        """Return the samples of a time span [ns], or some more."""
        return operands.read(self.name, start, end)

    def until(self, operands: Operands) -> int:
        """Return the time up to which the value is known [ns]."""
        return operands.last(self.name)

    def lookaround(self, _operands: Operands) -> Tuple[float, float]:
        """Return how far before and after a time samples affect the value [s]."""
        return 0.0, 0.0


class Elementwise:
    """Function of each sample; all arguments are evaluated at the times of the first.

    :param function: elementwise function of numpy
    :param arguments: its arguments; at least one is not a number
    """

    def __init__(self, function: Callable[..., numpy.ndarray], arguments: Sequence["Node"]) -> None:
        self._function, self._arguments = function, arguments
        self._signals = [one for one in arguments if not isinstance(one, Number)]
        self.fields: List[str] = list(
            dict.fromkeys(name for one in self._signals for name in one.fields)
        )

    def signal(self, operands: Operands, start: int, end: int) -> Signal:
        """See :meth:`Field.signal`."""
        first, *others = self._signals
        base = first.signal(operands, start, end)
        rows = [one.at(operands, base.times, start, end) for one in others]
        return base._replace(values=self._values([base.values, *rows]))

    def at(self, operands: Operands, times: numpy.ndarray, start: int, end: int) -> numpy.ndarray:
        """Return the values at some times of a time span [ns], from the arguments there."""
        return self._values([one.at(operands, times, start, end) for one in self._signals])

    def _values(self, rows: List[numpy.ndarray]) -> numpy.ndarray:
        row = iter(rows)
        with numpy.errstate(all="ignore"):
            return self._function(
                *(one.value if isinstance(one, Number) else next(row) for one in self._arguments)
            )

    def until(self, operands: Operands) -> int:
        """See :meth:`Field.until`."""
        return min(one.until(operands) for one in self._signals)

    def lookaround(self, operands: Operands) -> Tuple[float, float]:
        """See :meth:`Field.lookaround`."""
        back, ahead = self._signals[0].lookaround(operands)
        for other in self._signals[1:]:
            before, after = other.lookaround(operands)
            more = operands.longest_step(other.fields[0])
            back, ahead = max(back, before + more), max(ahead, after + more)
        return back, ahead


class Windowed(_Sampled):
    """Function of a window of a signal.

    :param of: the signal
    """

    def __init__(self, of: "Computed") -> None:
        self._of = of
        self.fields = of.fields

    def until(self, operands: Operands) -> int:
        """See :meth:`Field.until`."""
        return self._of.until(operands)


class Delay(Windowed):
    """Signal shifted in time.

    :param of: the signal
    :param seconds: the delay [s]; negative for earlier
    """

    def __init__(self, of: "Computed", seconds: float) -> None:
        super().__init__(of)
        self._seconds, self._ns = seconds, to_ns(seconds)

    def signal(self, operands: Operands, start: int, end: int) -> Signal:
        """See :meth:`Field.signal`."""
        found = self._of.signal(operands, shifted(start, -self._ns), shifted(end, -self._ns))
        return delayed(found, self._ns)

    def until(self, operands: Operands) -> int:
        """See :meth:`Field.until`."""
        return shifted(self._of.until(operands), self._ns)

    def lookaround(self, operands: Operands) -> Tuple[float, float]:
        """See :meth:`Field.lookaround`."""
        back, ahead = self._of.lookaround(operands)
        return back + self._seconds, ahead - self._seconds


class Derivative(Windowed):
    """Derivative of a signal per second, at the middle of each two samples."""

    def signal(self, operands: Operands, start: int, end: int) -> Signal:
        """See :meth:`Field.signal`."""
        more = to_ns(operands.longest_step(self.fields[0]))
        return slope(self._of.signal(operands, shifted(start, -more), shifted(end, more)))

    def until(self, operands: Operands) -> int:
        """See :meth:`Field.until`."""
        end = self._of.until(operands)
        begin = shifted(end, -to_ns(operands.longest_step(self.fields[0])))
        times = self._of.signal(operands, begin, end).between(to_ns(-math.inf), end).times[-2:]
        return int(times[0] + (times[1] - times[0]) // 2) if len(times) > 1 else to_ns(-math.inf)

    def lookaround(self, operands: Operands) -> Tuple[float, float]:
        """See :meth:`Field.lookaround`."""
        back, ahead = self._of.lookaround(operands)
        more = operands.longest_step(self.fields[0])
        return back + more, ahead + more


class LowPass(Windowed):
    """Signal filtered by a first-order low-pass.

    :param of: the signal
    :param cutoff: Hz
    """

    def __init__(self, of: "Computed", cutoff: float) -> None:
        super().__init__(of)
        self._cutoff = cutoff
        self._past = SETTLED / (2.0 * math.pi * cutoff)

    def signal(self, operands: Operands, start: int, end: int) -> Signal:
        """See :meth:`Field.signal`."""
        begin = shifted(start, -to_ns(self._past))
        return low_passed(self._of.signal(operands, begin, end), self._cutoff)

    def lookaround(self, operands: Operands) -> Tuple[float, float]:
        """See :meth:`Field.lookaround`."""
        back, ahead = self._of.lookaround(operands)
        return back + self._past, ahead


class Mean(Windowed):
    """Moving average of a signal.

    :param of: the signal
    :param seconds: length of the window [s]
    """

    def __init__(self, of: "Computed", seconds: float) -> None:
        super().__init__(of)
        self._seconds, self._ns = seconds, to_ns(seconds)

    def signal(self, operands: Operands, start: int, end: int) -> Signal:
        """See :meth:`Field.signal`."""
        return averaged(self._of.signal(operands, shifted(start, -self._ns), end), self._ns)

    def lookaround(self, operands: Operands) -> Tuple[float, float]:
        """See :meth:`Field.lookaround`."""
        back, ahead = self._of.lookaround(operands)
        return back + self._seconds, ahead


class Extreme(Windowed):
    """Maximum or minimum of a signal around each time.

    :param of: the signal
    :param seconds: half-width of the window [s]
    """

    pick: numpy.ufunc

    def __init__(self, of: "Computed", seconds: float) -> None:
        super().__init__(of)
        self._seconds, self._ns = seconds, to_ns(seconds)

    def signal(self, operands: Operands, start: int, end: int) -> Signal:
        """See :meth:`Field.signal`."""
        found = self._around(operands, start, end)
        return found._replace(values=extreme(found, found.times, self._ns, self.pick))

    def at(self, operands: Operands, times: numpy.ndarray, start: int, end: int) -> numpy.ndarray:
        """Return the maxima or minima around some times, not around the sample times."""
        return extreme(self._around(operands, start, end), times, self._ns, self.pick)

    def until(self, operands: Operands) -> int:
        """See :meth:`Field.until`."""
        return shifted(self._of.until(operands), -self._ns)

    def lookaround(self, operands: Operands) -> Tuple[float, float]:
        """See :meth:`Field.lookaround`."""
        back, ahead = self._of.lookaround(operands)
        more = self._seconds + operands.longest_step(self.fields[0])
        return back + more, ahead + more

    def _around(self, operands: Operands, start: int, end: int) -> Signal:
        more = to_ns(self._seconds + operands.longest_step(self.fields[0]))
        return self._of.signal(operands, shifted(start, -more), shifted(end, more))


class Highest(Extreme):
    """Maximum around each time."""

    pick = numpy.maximum


class Lowest(Extreme):
    """Minimum around each time."""

    pick = numpy.minimum


Computed = Union[Field, Elementwise, Delay, Derivative, LowPass, Mean, Highest, Lowest]
Node = Union[Number, Computed]
