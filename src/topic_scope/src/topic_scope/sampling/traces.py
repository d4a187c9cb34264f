# Pure: knows no ROS.
"""The samples of fields, by the times of their messages."""

import math
from typing import List, Optional, Tuple

import numpy

from topic_scope.analysis.ring import Ring, Samples
from topic_scope.formulas.signals import Signal
from topic_scope.messages import derived, fields, timestamp_source
from topic_scope.messages.decoding import Decoder
from topic_scope.messages.definitions import Record
from topic_scope.sampling.message_source import Batch

#: More than any rounding of a time since the epoch [s].
_MORE_S = 1e-5
#: How many samples tell what is usual between them.
_USUAL = 200
#: Why a derivative jumps.
JUMPS = "timed by reception: the derivative jumps where messages come early or late"


class Stream:
    """Traces of one topic that go by one time.

    :param topic: the topic
    :param timestamp: name of the time; see :func:`.timestamp_source.path_of`

    :ivar traces: those that are recorded
    """

    def __init__(self, topic: str, timestamp: str) -> None:
        self.topic = topic
        self.traces: List["Trace"] = []
        self._timestamp = timestamp
        self._layout: Optional[Record] = None
        self._path: Optional[fields.Path] = None
        self._decoder: Optional[Decoder] = None
        self._latest: Optional[Tuple[List[bytes], numpy.ndarray, numpy.ndarray]] = None
        self._time = timestamp_source.OwnClock(None)

    @property
    def offset(self) -> float:
        """Offset from the times in the rings to those of the scope [s]."""
        return self._time.offset

    @property
    def path(self) -> Optional[fields.Path]:
        """Path of the stamp in the messages; None for the time of reception."""
        return self._path if self._time.is_said else None

    @property
    def timestamp(self) -> str:
        """The name of the time that is in use."""
        return timestamp_source.name_of(self.path)

    @property
    def correction(self) -> Optional[str]:
        """Correction of the stamps, as text; None without one."""
        return timestamp_source.correction(self.path, self.offset)

    def record(self, path: fields.Path, history: float, function: str = "") -> "Trace":
        """Record one more field; see :class:`Trace`."""
        trace = Trace(self, path, history, function)
        if self._layout is not None:
            trace.read_as(self._layout)
        if self._latest is not None:  # there may be no other, where it is latched
            trace.add(*self._latest)
        self.traces.append(trace)
        return trace

    def add(self, layout: Record, batch: Batch) -> float:
        """Take some messages.

        :param layout: their layout
        :param batch: the messages
        :returns: the time of the earliest one [s]; minus infinity where earlier samples have moved
        """
        if layout is not self._layout:
            self._read_as(layout)
        if self._decoder is None:
            return self._add(batch, None)
        own = self._decoder.decode(batch.messages)
        # A part for each time that the clock was set back: of a bag much comes at once.
        ends = ((own[1:] - own[:-1] < -timestamp_source.BACK_S).nonzero()[0] + 1).tolist()
        if not ends:
            return self._add(batch, own)
        return min(
            self._add(Batch(batch.header, batch.times[part], batch.messages[part]), own[part])
            for part in map(slice, [0, *ends], [*ends, len(own)])
        )

    def _add(self, batch: Batch, own: Optional[numpy.ndarray]) -> float:
        times = received = numpy.array(batch.times)
        offset = self.offset
        if own is not None:
            times, back = self._time.convert(own, received)
            if back:
                for trace in self.traces:
                    trace.move(back)
        for trace in self.traces:
            trace.add(batch.messages, times, received)
        self._latest = (batch.messages[-1:], times[-1:], received[-1:])
        return float(times.min()) + offset if offset == self.offset else -numpy.inf

    def _read_as(self, layout: Record) -> None:
        self._layout, self._latest = layout, None
        try:
            path = timestamp_source.path_of(self._timestamp, layout)
            exact = timestamp_source.is_exact(self._timestamp, layout)
        except fields.FieldError:  # the topic has got another type
            path, exact = None, False
        if path != self._path:
            for trace in self.traces:  # what is there goes by the scope's clock from now on
                trace.move(self.offset)
            latest = [trace.ring.latest(1) for trace in self.traces]
            before = float(numpy.concatenate([[-numpy.inf], *latest]).max())
            self._time = timestamp_source.OwnClock(path, exact, before)
        self._path = path
        self._decoder = None if path is None else decoder_of(layout, path)
        for trace in self.traces:
            trace.read_as(layout)


class Trace:
    """The samples of one field.

    :param stream: where they come from
    :param path: where the field stands in a message
    :param history: how long samples are kept [s]
    :param function: name of what is computed of it, see :mod:`.derived`; empty for nothing

    :ivar ring: the samples, by the own clock of their messages
    :ivar used_at: when a page last showed it [s]
    """

    def __init__(
        self, stream: Stream, path: fields.Path, history: float, function: str = ""
    ) -> None:
        self._stream = stream
        self.path = path
        self.ring = Ring(history)
        self.used_at = 0.0
        self._pinned = (math.inf, -math.inf)
        self._pinned_offset = 0.0
        self._longest_step: Optional[float] = None
        self._new = 0
        self._function = derived.make(function)
        self._is_derivative = function == derived.DERIVATIVE
        #: Where a message has no element of that name it is about others: no gap, but no sample.
        self._is_named = any(isinstance(part, fields.Key) for part in path)
        self._paths = [path + part for part in derived.parts(function)]
        self._decoders: List[Decoder] = []

    @property
    def stream(self) -> Stream:
        """Stream that the samples come from."""
        return self._stream

    @property
    def jumps(self) -> Optional[str]:
        """Why it jumps, in words; None where it need not."""
        return JUMPS if self._is_derivative and self.stream.path is None else None

    def read_as(self, layout: Record) -> None:
        """Read messages of this layout from now on; nothing, where it has no such field."""
        found = [decoder_of(layout, path) for path in self._paths]
        self._decoders = [decoder for decoder in found if decoder is not None]
        self._longest_step = None

    def add(self, messages: List[bytes], times: numpy.ndarray, received: numpy.ndarray) -> None:
        """Take the samples of some messages.

        :param messages: the messages
        :param times: when they were taken, by their own clock [s]
        :param received: when they were received [s]
        """
        if len(self._decoders) == len(self._paths):
            rows = numpy.array([decoder.decode(messages) for decoder in self._decoders])
            if self._is_named and numpy.isnan(rows).any():
                there = [all(one.has(data) for one in self._decoders) for data in messages]
                rows, times, received = rows[:, there], times[there], received[there]
            times, values = self._function(times, rows, self.longest_step)
            late = len(received) - len(values)  # what is computed of two begins with the second
            self.ring.append(times, values, received[late:])
            self._new += len(values)
            if self._new > _USUAL // 2 or len(self.ring) < _USUAL:
                self._longest_step, self._new = None, 0

    def samples(self, start: float, end: float) -> Samples:
        """Return times and values of a time span by the scope's clock, its ends included [s]."""
        times, values, _ = self._between(start, end)
        return times, values

    def received(self, start: float, end: float) -> numpy.ndarray:
        """Return when the samples of a time span were received [s]."""
        return self._between(start, end)[2]

    def signal(self, start: float, end: float) -> Signal:
        """Return the samples of a time span [s], for a formula."""
        times, values, received = self._between(start, end)
        return Signal(times, values, received, self.longest_step)

    def latency(self, start: float, end: float) -> numpy.ndarray:
        """Return how long after they were taken the samples of a time span were received [s].

        :returns: by the clocks as they are, with no correction; nothing for times of receipt
        """
        if self.stream.path is None:
            return numpy.empty(0)
        times, _, received = self._between(start, end)
        return received - (times - self._offset_at(start, end))

    def pin(self, start: float, end: float) -> None:
        """Keep the samples of a time span, and no others, when their time is over [s]."""
        if (start, end) != self._pinned:
            if self._pinned[0] > self._pinned[1]:  # nothing has been
                self._pinned_offset = self.stream.offset
            self._pinned = (start, end)
            self.ring.pin(start - self._pinned_offset, end - self._pinned_offset)

    def move(self, by: float) -> None:
        """Move all samples by their own clock, which was set back; they stay where they are here.

        :param by: how far [s]
        """
        self.ring.move(by)
        self._pinned_offset -= by

    @property
    def span(self) -> Optional[Tuple[float, float]]:
        """Times of the first and the last sample [s]; None without samples."""
        times, _, _ = self._between(-math.inf, math.inf)
        return (min(float(times[0]), self._pinned[0]), float(times[-1])) if len(times) else None

    @property
    def longest_step(self) -> float:
        """Longest step between samples of one line [s], from the latest samples."""
        if self._longest_step is None:
            latest = self.ring.latest(_USUAL)
            self._longest_step = timestamp_source.longest_step(self.stream.path, latest)
        return self._longest_step

    @property
    def whole_from(self) -> float:
        """After when no sample is missing [s]; minus infinity where none was forgotten."""
        if not self.ring.has_forgotten or len(self.ring) < 2:
            return -math.inf
        first, second = self.ring.between(-math.inf, math.inf)[0, :2]
        # The last one that was forgotten: as far before the first as that is before the next one,
        # unless there is a gap between these.
        return float(first - min(second - first, self.longest_step)) + self.stream.offset

    def age(self, now: float) -> Optional[float]:
        """Return how long ago its last sample was taken [s]; None without one.

        :param now: the time [s]
        """
        latest = self.ring.latest(1)
        return now - float(latest[0]) - self.stream.offset if len(latest) else None

    def silence(self, now: float) -> Optional[float]:
        """Return for how long nothing has been received [s]; None where there is no sample.

        :param now: the time [s]
        """
        last = self.ring.last_received
        return None if last is None else now - last

    def _offset_at(self, start: float, end: float) -> float:
        """Return what is to be added to the own times of a time span to get the scope's [s]."""
        if self._pinned[0] <= (start + end) / 2.0 <= self._pinned[1]:
            # The clocks may have gone apart since, as where a simulation is slower.
            return self._pinned_offset
        return self.stream.offset

    def _between(self, start: float, end: float) -> Tuple[numpy.ndarray, ...]:
        # Sought with some more, as the ends are rounded otherwise than the samples' times.
        offset = self._offset_at(start, end)
        if not offset:
            return tuple(self.ring.between(start, end))
        times, *others = self.ring.between(start - offset - _MORE_S, end - offset + _MORE_S)
        times = times + offset
        inside = slice(times.searchsorted(start), times.searchsorted(end, "right"))
        return tuple(row[inside] for row in (times, *others))


def decoder_of(layout: Record, path: fields.Path) -> Optional[Decoder]:
    """Return what reads a place in messages; None where they have no such place."""
    try:
        return Decoder(layout, path)
    except fields.FieldError:  # the topic has got another type
        return None
