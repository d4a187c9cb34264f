# Pure: knows no ROS.
"""Traces: recorded samples of message fields over time, by stamp or by time of reception."""

import contextlib
import math
from typing import List, Optional, Protocol, Tuple, Union

import numpy

from topic_scope.analysis.ring import NOWHERE, Ring, Rows, Samples
from topic_scope.formulas.signals import Signal
from topic_scope.messages import field_functions, fields, timestamp_source
from topic_scope.messages.decoding import Decoder, rounding_text
from topic_scope.messages.message_layout import MessageLayout
from topic_scope.messages.states import StateDecoder, StateTable
from topic_scope.sampling.message_source import Batch
from topic_scope.timing.clocks import ELSEWHERE_NS, Clock, Clocks
from topic_scope.timing.nanoseconds import NS, ROUNDED_NS, shifted, to_ns
from topic_scope.timing.topic_time import PlacedMessages, TopicTime

#: Number of samples that determine the usual interval.
_USUAL = 200
#: Why a derivative may jump.
JUMPS = "timed by reception: the derivative jumps where messages come early or late"
#: Why there is no latency.
_NO_LATENCY = "the stamps are of another clock: no latency"


class MessageSink(Protocol):
    """Receiver of the placed messages of a stream."""

    def read_as(self, layout: MessageLayout) -> None:
        """Read messages with this layout from now on."""

    def add(
        self, messages: List[bytes], times: numpy.ndarray, received: numpy.ndarray, newest: int
    ) -> None:
        """Add messages.

        :param messages: the messages
        :param times: when they were taken, by their own clock [ns]
        :param received: when they were received [ns]
        :param newest: the latest plausible time [ns]
        """

    def move(self, by: int) -> None:
        """Shift all times after the clock was set [ns]."""


class Stream:
    """Stream of messages of one topic, for traces with the same timestamp source.

    :param topic: the topic
    :param timestamp: name of the timestamp source; see :func:`.timestamp_source.path_of`
    :param clocks: the clocks of all topics

    :ivar sinks: the recorded traces and images
    :ivar leader: stream of the topic whose clock the user chose; None without a choice
    """

    def __init__(self, topic: str, timestamp: str, clocks: Optional[Clocks] = None) -> None:
        self.topic = topic
        self.sinks: List[MessageSink] = []
        self.leader: Optional[Stream] = None
        self._timestamp = timestamp
        self._clocks = clocks or Clocks()
        self._layout: Optional[MessageLayout] = None
        self._path: Optional[fields.Path] = None
        self._decoder: Optional[Decoder] = None
        self._latest: Optional[Tuple[List[bytes], numpy.ndarray, numpy.ndarray]] = None
        self._time = TopicTime(self._clocks)
        #: Messages that wait for others to confirm their stamps, and their stamps.
        self._waiting: Optional[Tuple[Batch, numpy.ndarray]] = None

    @property
    def has_begun(self) -> bool:
        """Whether the stream has received a message."""
        return self._layout is not None

    @property
    def offset(self) -> int:
        """Offset from the times in the rings to the scope's clock [ns]."""
        return self.present_clock().offset

    def follow(self, leader: Optional["Stream"]) -> None:
        """Use the clock of another topic; None to estimate it."""
        self.leader = leader
        self._time.choose(None if leader is None else leader.present_clock)

    def present_clock(self) -> Clock:
        """Return the current clock of the stamps; it changes when the clock is set."""
        return self._time.clock

    @property
    def path(self) -> Optional[fields.Path]:
        """Path of the stamp in the messages; None for the time of reception."""
        return self._path if self._time.has_stamps else None

    @property
    def timestamp(self) -> str:
        """Name of the timestamp source in use."""
        return timestamp_source.name_of(self.path)

    @property
    def correction(self) -> Optional[str]:
        """Correction of the stamps, and contradicted stamps, as text; None without any."""
        if self.leader is None or self.path is None:
            return timestamp_source.oddities(self._path, self._time)
        shift = f"by the clock of {self.leader.topic}, shifted by {self.offset / NS:.6g} s"
        return "; ".join(filter(None, (shift, self._time.outliers.text)))

    @property
    def no_latency(self) -> Optional[str]:
        """Why there is no latency, as text; None if there is."""
        return _NO_LATENCY if self.path and abs(self.offset) > ELSEWHERE_NS else None

    def record(self, path: fields.Path, history: float, function: str = "") -> "Trace":
        """Record an additional field; see :class:`Trace`."""
        trace = Trace(self, path, history, function)
        self.attach(trace)
        return trace

    def attach(self, sink: MessageSink) -> None:
        """Add a sink for the latest message and all later ones."""
        if self._layout is not None:
            sink.read_as(self._layout)
        if self._latest is not None:  # the only message of a latched topic
            messages, times, received = self._latest
            sink.add(messages, times, received, int(times[-1]))
        self.sinks.append(sink)

    def add(self, layout: MessageLayout, batch: Batch) -> float:
        """Add messages.

        :param layout: their layout
        :param batch: the messages
        :returns: the time of the earliest message [s]; infinity if all of them wait for others
        """
        if layout is not self._layout:
            self._read_as(layout)
        if self._decoder is None or self._path is None:
            received = numpy.array(batch.times, numpy.int64)
            return self._add(
                [PlacedMessages(self._time.clock, received, 0, 0)], batch.messages, received
            )
        own = timestamp_source.read_times(self._decoder, self._path, batch.messages)
        if self._waiting is not None:
            before, stamps = self._waiting
            own = numpy.concatenate([stamps, own])
            times = [*before.times, *batch.times]
            batch = Batch(batch.header, times, before.messages + batch.messages)
        return self._place(batch, own, False)

    def release(self, now: int) -> float:
        """Place messages that have waited too long for others to confirm their stamps.

        :param now: the time [ns]
        :returns: as :meth:`add`
        """
        if self._waiting is None or now < self._waiting[0].times[0] + self._time.patience:
            return math.inf
        return self._place(*self._waiting, True)

    def _place(self, batch: Batch, own: numpy.ndarray, is_final: bool) -> float:
        received = numpy.array(batch.times, numpy.int64)
        placed = self._time.place(own, received, is_final)
        count = sum(len(part.times) for part in placed)
        self._waiting = None
        if count < len(own):
            rest = Batch(batch.header, batch.times[count:], batch.messages[count:])
            self._waiting = rest, own[count:]
        return self._add(placed, batch.messages[:count], received[:count])

    def _add(
        self, placed: List[PlacedMessages], messages: List[bytes], received: numpy.ndarray
    ) -> float:
        start, earliest = 0, math.inf
        for _, times, newest, moved in placed:
            if moved:
                for sink in self.sinks:
                    sink.move(moved)
            part = slice(start, start + len(times))
            start = part.stop
            newest = newest or int(times[-1])
            for sink in self.sinks:
                sink.add(messages[part], times, received[part], newest)
            earliest = min(earliest, float(times.min() + self.offset) / NS)
            self._latest = (messages[part][-1:], times[-1:], received[part][-1:])
        return earliest

    def _read_as(self, layout: MessageLayout) -> None:
        if self._waiting is not None:
            self._place(*self._waiting, True)
        self._layout, self._latest = layout, None
        try:
            path = timestamp_source.path_of(self._timestamp, layout)
        except fields.FieldError:  # the type of the topic has changed
            path = None
        if path != self._path:
            for sink in self.sinks:  # existing samples use the scope's clock from now on
                sink.move(self.offset)
            named = self._timestamp if path is not None else timestamp_source.RECEIVED
            self._time = timestamp_source.topic_time(self._clocks, named, layout)
            self.follow(self.leader)
        self._path = path
        self._decoder = None if path is None else decoder_of(layout, path)
        for sink in self.sinks:
            sink.read_as(layout)


class Trace:
    """Recorded samples of one field.

    :param stream: stream of its topic
    :param path: path of the field in a message
    :param history: how long samples are kept [s]
    :param function: name of the function applied to it, see :mod:`.field_functions`; empty for none

    :ivar ring: the samples, by the own clock of their messages
    :ivar used_at: when a page last showed it [s]
    :ivar states: texts of the state numbers; None for a numeric trace
    """

    def __init__(
        self, stream: Stream, path: fields.Path, history: float, function: str = ""
    ) -> None:
        self._stream = stream
        self.path = path
        self.ring = Ring(history)
        self.used_at = 0.0
        self._pinned = NOWHERE
        self._pinned_offset = 0
        self._pinned_leader: Optional[Stream] = None
        self._longest_step: Optional[float] = None
        self._new = 0
        self._function = field_functions.make(function)
        self._is_derivative = function == field_functions.DERIVATIVE
        #: Whether the path names an element: messages without it have no sample, and make no gap.
        self._is_named = any(isinstance(part, fields.Key) for part in path)
        self._paths = [path + part for part in field_functions.parts(function)]
        self.states = StateTable() if function == field_functions.STATE else None
        self._decoders: List[Union[Decoder, StateDecoder]] = []
        self._rounding = 1

    @property
    def correction(self) -> Optional[str]:
        """Correction of stamps and values, as text; None without one."""
        note = self.states.note if self.states is not None else None
        texts = (self.stream.correction, rounding_text(self._rounding), note)
        return "; ".join(filter(None, texts)) or None

    @property
    def is_read(self) -> bool:
        """Whether the messages have the field."""
        return bool(self._decoders)

    @property
    def stream(self) -> Stream:
        """Stream of the samples."""
        return self._stream

    @property
    def jumps(self) -> Optional[str]:
        """Why the trace may jump, as text; None if it does not."""
        return JUMPS if self._is_derivative and self.stream.path is None else None

    def read_as(self, layout: MessageLayout) -> None:
        """Read messages of this layout from now on, if it has the field."""
        self._decoders, self._longest_step = [], None
        with contextlib.suppress(fields.FieldError):  # the type of the topic has changed
            if self.states is not None:
                self._decoders = [StateDecoder(layout, self.path, self.states)]
            else:
                self._decoders = [Decoder(layout, one) for one in self._paths]

    def add(
        self, messages: List[bytes], times: numpy.ndarray, received: numpy.ndarray, newest: int
    ) -> None:
        """Add the samples of messages; see :meth:`MessageSink.add`."""
        if self.is_read:
            rows = numpy.array([decoder.decode(messages) for decoder in self._decoders])
            for decoder, row in zip(self._decoders, rows):
                self._rounding = max(self._rounding, decoder.rounding(row))
            if self._is_named and numpy.isnan(rows).any():
                there = [all(one.has(data) for one in self._decoders) for data in messages]
                rows, times, received = rows[:, there], times[there], received[there]
            times, values = self._function(times, rows, self.longest_step)
            late = len(received) - len(values)  # a value of two samples starts at the second
            self.ring.append(times, values, received[late:], newest)
            self._new += len(values)
            if self._new > _USUAL // 2 or len(self.ring) < _USUAL:
                self._longest_step, self._new = None, 0

    def samples(self, start: float, end: float) -> Samples:
        """Return times and values of a time span by the scope's clock, its ends included [s]."""
        times, values, _ = self.rows(to_ns(start) - ROUNDED_NS, to_ns(end) + ROUNDED_NS)
        return times / NS, values

    def signal(self, start: int, end: int) -> Signal:
        """Return the samples of a time span [ns], for a formula."""
        return Signal(*self.rows(start, end), self.longest_step)

    def rows(self, start: int, end: int) -> Rows:
        """Return the samples of a time span by the scope's clock, its ends included [ns]."""
        offset = self._offset_at(start, end)
        if not offset:
            return self.ring.between(start, end)
        span = shifted(start, -offset), shifted(end, -offset)
        times, values, received = self.ring.between(*span)
        return times + offset, values, received

    def latency(self, start: float, end: float) -> numpy.ndarray:
        """Return the latencies in a time span, from stamp to receipt [s].

        :returns: by the uncorrected clocks; empty for times of receipt, and
            for stamps that do not count from the epoch
        """
        if self.stream.path is None or self.stream.no_latency:
            return numpy.empty(0)
        first, last = to_ns(start) - ROUNDED_NS, to_ns(end) + ROUNDED_NS
        times, _, received = self.rows(first, last)
        return (received - times + self._offset_at(first, last)) / NS

    def pin(self, start: float, end: float) -> None:
        """Keep the samples of a time span beyond the history [s]."""
        span = (to_ns(start), to_ns(end)) if start <= end else NOWHERE
        is_chosen = self.stream.leader is not self._pinned_leader  # the user chose another clock
        if span != self._pinned or is_chosen:
            if self._pinned == NOWHERE or is_chosen:
                self._pinned_offset = self.stream.offset
            self._pinned, self._pinned_leader = span, self.stream.leader
            if span != NOWHERE:
                span = (span[0] - self._pinned_offset, span[1] - self._pinned_offset)
            self.ring.pin(*span)

    def move(self, by: int) -> None:
        """Shift all samples after their clock was set; they are still shown at the same times.

        :param by: the shift [ns]
        """
        self.ring.move(by)
        self._pinned_offset -= by

    @property
    def span(self) -> Optional[Tuple[float, float]]:
        """Times of the first and the last sample [s]; None without samples."""
        times, _, _ = self.ring.between(to_ns(-math.inf), to_ns(math.inf))
        if not len(times):
            return None
        first, last = (int(time) + self.stream.offset for time in (times[0], times[-1]))
        return min(first, self._pinned[0]) / NS, last / NS

    @property
    def longest_step(self) -> float:
        """Longest time between connected samples [s], from the latest samples."""
        if self._longest_step is None:
            latest = self.ring.latest(_USUAL)
            self._longest_step = timestamp_source.longest_step(self.stream.path, latest)
        return self._longest_step

    @property
    def whole_from(self) -> int:
        """Time after which no sample is missing [ns]; the earliest time if none was dropped."""
        if not self.ring.has_forgotten or len(self.ring) < 2:
            return to_ns(-math.inf)
        first, second = self.ring.between(to_ns(-math.inf), to_ns(math.inf))[0][:2].tolist()
        # Estimated time of the last dropped sample: as far before the first as that is before the
        # second, unless there is a gap between these.
        return int(first - min(second - first, to_ns(self.longest_step))) + self.stream.offset

    @property
    def last(self) -> int:
        """Time of the last sample [ns]; the earliest time without samples."""
        latest = self.ring.latest(1)
        return int(latest[0]) + self.stream.offset if len(latest) else to_ns(-math.inf)

    def silence(self, now: float) -> Optional[float]:
        """Return the time since the last receipt [s]; None without samples.

        :param now: the time [s]
        """
        last = self.ring.last_received
        return None if last is None else now - last / NS

    def _offset_at(self, start: int, end: int) -> int:
        """Return the offset from the stamps of a time span to the scope's clock [ns]."""
        if self._pinned[0] <= (start + end) // 2 <= self._pinned[1]:
            # The clocks may have drifted apart since, e.g. in a slow simulation.
            return self._pinned_offset
        return self.stream.offset


def decoder_of(layout: MessageLayout, path: fields.Path) -> Optional[Decoder]:
    """Return the decoder of a path; None if the messages do not have it."""
    try:
        return Decoder(layout, path)
    except fields.FieldError:  # the type of the topic has changed
        return None
