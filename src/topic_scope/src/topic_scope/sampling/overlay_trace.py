# Pure: knows no ROS.
"""Traces of a bag that is overlaid on live ones: all samples of a field, shiftable in time."""

import math
from typing import Mapping, Optional, Protocol, Sequence

import numpy

from topic_scope.analysis.ring import Rows
from topic_scope.messages.arrays import Arrays
from topic_scope.messages.message_layout import MessageLayout
from topic_scope.messages.fields import Path
from topic_scope.messages.states import StateTable
from topic_scope.sampling.traces import Stream, Trace
from topic_scope.timing.nanoseconds import array_to_ns

_READING, _NOTHING = "the bag is being read", "the bag does not have this number"


class Overlay(Protocol):
    """Overlaid bag."""

    @property
    def place_ns(self) -> int:
        """Start by the scope's clock [ns]."""

    @property
    def layouts(self) -> Mapping[str, MessageLayout]:
        """Layouts of its messages by topic."""

    @property
    def arrays(self) -> Mapping[str, Arrays]:
        """Arrays in its messages by topic."""

    def trace(self, topic: str, path: Path, timestamp: str, function: str) -> "OverlayTrace":
        """Return one of its traces, which is filled later; see :class:`OverlayTrace`."""


class OverlayStream(Stream):
    """Topic and time offset of an overlay's traces.

    :param topic: the topic
    :param timestamp: name of the timestamp source
    :param path: path of the timestamp in the messages
    :param overlay: the overlay
    """

    def __init__(self, topic: str, timestamp: str, path: Optional[Path], overlay: Overlay) -> None:
        super().__init__(topic, timestamp)
        self._path = path
        self._overlay = overlay
        self.words: Optional[str] = None

    @property
    def offset(self) -> int:
        """Start of the overlay [ns], the zero of its samples."""
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
    """All samples of a field of an overlay.

    :param stream: its topic and time offset
    :param path: path of the field in a message
    :param function: name of the function applied to it

    :ivar problem: why there are no samples; None if there are
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
        """Set all samples.

        :param times: ascending, s since the start of the overlay
        :param values: NaN at the end of a line
        :param correction: description of shifted times
        :param states: texts of the state numbers in ``values``; None for numbers
        """
        if states is not None:
            self.states = StateTable(states)
        at = array_to_ns(numpy.array(times))
        self.ring.append(at, numpy.array(values), at)
        self._laid.words = correction
        self._longest_step = None
        self.problem = None if numpy.isfinite(values).any() else _NOTHING

    def pin(self, start: float, end: float) -> None:
        """Do nothing: all samples are kept."""

    def latency(self, start: float, end: float) -> numpy.ndarray:
        """Return an empty array: the recorder's clock is not the scope's."""
        return numpy.empty(0)

    def silence(self, now: float) -> Optional[float]:
        """Return 0, because no messages are expected; None without samples."""
        return 0.0 if len(self.ring) else None

    def rows(self, start: int, end: int) -> Rows:
        """See :meth:`.Trace.rows`; the receipt times are the times of recording."""
        times, values, _ = super().rows(start, end)
        return times, values, times
