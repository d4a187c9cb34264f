# Pure: knows no ROS.
"""Traces of an overlaid bag, complete from the start, and movable in time."""

import math
from typing import Mapping, Optional, Protocol, Sequence

import numpy

from topic_scope.analysis.ring import Rows
from topic_scope.messages.arrays import Arrays
from topic_scope.messages.definitions import Record
from topic_scope.messages.fields import Path
from topic_scope.messages.states import StateTable
from topic_scope.sampling.traces import Stream, Trace
from topic_scope.timing.nanoseconds import array_to_ns

_READING, _NOTHING = "the bag is being read", "the bag has no number there"


class Overlay(Protocol):
    """Overlaid bag."""

    @property
    def place_ns(self) -> int:
        """Start by the scope's clock [ns]."""

    @property
    def layouts(self) -> Mapping[str, Record]:
        """The layouts of its messages, by the names of its topics."""

    @property
    def arrays(self) -> Mapping[str, Arrays]:
        """The arrays in its messages, by the names of its topics."""

    def trace(self, topic: str, path: Path, timestamp: str, function: str) -> "OverlayTrace":
        """Return one of its traces, which has its samples later; see :class:`OverlayTrace`."""


class OverlayStream(Stream):
    """Gives a trace of an overlay its topic and its place in time.

    :param topic: the topic
    :param timestamp: name of the time
    :param path: where that stands in the messages
    :param overlay: what it is a part of
    """

    def __init__(self, topic: str, timestamp: str, path: Optional[Path], overlay: Overlay) -> None:
        super().__init__(topic, timestamp)
        self._path = path
        self._overlay = overlay
        self.words: Optional[str] = None

    @property
    def offset(self) -> int:
        """Start of the overlay [ns]: its samples count from there."""
        return self._overlay.place_ns

    @property
    def path(self) -> Optional[Path]:
        """Path of the stamp in the messages; None for the time of recording."""
        return self._path

    @property
    def correction(self) -> Optional[str]:
        """Correction of the stamps, as text; None without one."""
        return self.words


class OverlayTrace(Trace):
    """The samples of a field, from its first to its last one.

    :param stream: gives it its place
    :param path: where the field stands in a message
    :param function: name of what is computed of it

    :ivar problem: why there are no samples, in words; None where there are
    """

    def __init__(self, stream: OverlayStream, path: Path, function: str) -> None:
        super().__init__(stream, path, math.inf, function)
        self.problem: Optional[str] = _READING
        self._laid = stream

    def fill(
        self,
        times: numpy.ndarray,
        values: numpy.ndarray,
        correction: Optional[str],
        states: Optional[Sequence[str]] = None,
    ) -> None:
        """Take all samples.

        :param times: ascending, s from the begin of the overlay on
        :param values: NaN where a line ends
        :param correction: how the times were moved, in words
        :param states: texts whose numbers the values are; None for numbers
        """
        if states is not None:
            self.states = StateTable(states)
        at = array_to_ns(numpy.array(times))
        self.ring.append(at, numpy.array(values), at)
        self._laid.words = correction
        self._longest_step = None
        self.problem = None if numpy.isfinite(values).any() else _NOTHING

    def pin(self, start: float, end: float) -> None:
        """Do nothing: all samples are kept anyway."""

    def latency(self, start: float, end: float) -> numpy.ndarray:
        """Return nothing: what it was recorded by is another clock."""
        return numpy.empty(0)

    def silence(self, now: float) -> Optional[float]:
        """Return 0: it waits for nothing; None where there is no sample."""
        return 0.0 if len(self.ring) else None

    def rows(self, start: int, end: int) -> Rows:
        """As of :class:`.Trace`; received when they were recorded."""
        times, values, _ = super().rows(start, end)
        return times, values, times
