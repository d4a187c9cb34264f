"""The samples of one field, by the times of their messages."""

import math
from typing import List, Optional, Protocol, Tuple

import numpy

from topic_scope.analysis.ring import Ring, Samples
from topic_scope.messages import derived, fields, timestamp_source
from topic_scope.messages.decoding import Decoder
from topic_scope.messages.definitions import Record

#: More than any rounding of a time since the epoch, s.
_MORE_S = 1e-5
#: How many samples tell what is usual between them.
_USUAL = 200


class Timed(Protocol):
    """What the samples of a topic go by; see :class:`.streams.Stream`."""

    topic: str

    @property
    def timestamp(self) -> str:
        ...

    @property
    def path(self) -> Optional[fields.Path]:
        ...

    @property
    def offset(self) -> float:
        ...


class Recorded(Protocol):
    """What can be asked of the samples of a field, or of what is made of several; see Trace."""

    @property
    def stream(self) -> Timed:
        ...

    @property
    def span(self) -> Optional[Tuple[float, float]]:
        ...

    @property
    def longest_step(self) -> float:
        ...

    def samples(self, start: float, end: float) -> Samples:
        ...

    def received(self, start: float, end: float) -> numpy.ndarray:
        ...

    def age(self, now: float) -> Optional[float]:
        ...


class Trace:
    """The samples of one field.

    :param stream: where they come from
    :param path: where the field stands in a message
    :param history: how long samples are kept, s
    :param function: name of what is computed of it, see :mod:`.derived`; empty for nothing

    :ivar ring: the samples, by the own clock of their messages
    :ivar used_at: when somebody has looked at it, s
    """

    def __init__(
        self, stream: Timed, path: fields.Path, history: float, function: str = ""
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
        #: Where a message has no element of that name it is about others: no gap, but no sample.
        self._is_named = any(isinstance(part, fields.Key) for part in path)
        self._paths = [path + part for part in derived.parts(function)]
        self._decoders: List[Decoder] = []

    @property
    def stream(self) -> Timed:
        """Where they come from."""
        return self._stream

    def read_as(self, layout: Record) -> None:
        """Read messages of this layout from now on; nothing, where it has no such field."""
        found = [decoder_of(layout, path) for path in self._paths]
        self._decoders = [decoder for decoder in found if decoder is not None]
        self._longest_step = None

    def add(self, messages: List[bytes], times: numpy.ndarray, received: numpy.ndarray) -> None:
        """Take the samples of some messages.

        :param messages: the messages
        :param times: when they were taken, by their own clock, s
        :param received: when they were received, s
        """
        if len(self._decoders) == len(self._paths):
            rows = numpy.array([decoder.decode(messages) for decoder in self._decoders])
            if self._is_named and numpy.isnan(rows).any():
                there = [all(one.has(data) for one in self._decoders) for data in messages]
                rows, times, received = rows[:, there], times[there], received[there]
            values = self._function(times, rows)
            late = len(times) - len(values)  # what is computed of two begins with the second
            self.ring.append(times[late:], values, received[late:])
            self._new += len(values)
            if self._new > _USUAL // 2 or len(self.ring) < _USUAL:
                self._longest_step, self._new = None, 0

    def samples(self, start: float, end: float) -> Samples:
        """Return times and values of a time span by the scope's clock, its ends included, s."""
        times, values, _ = self._between(start, end)
        return times, values

    def received(self, start: float, end: float) -> numpy.ndarray:
        """Return when the samples of a time span were received, s."""
        return self._between(start, end)[2]

    def pin(self, start: float, end: float) -> None:
        """Keep the samples of a time span, and no others, when their time is over, s."""
        if (start, end) != self._pinned:
            if self._pinned[0] > self._pinned[1]:  # nothing has been
                self._pinned_offset = self.stream.offset
            self._pinned = (start, end)
            self.ring.pin(start - self._pinned_offset, end - self._pinned_offset)

    def move(self, by: float) -> None:
        """Move all samples by their own clock, which was set back; they stay where they are here.

        :param by: how far, s
        """
        self.ring.move(by)
        self._pinned_offset -= by

    @property
    def span(self) -> Optional[Tuple[float, float]]:
        """The times of the first and the last sample, s; None where there is none."""
        times, _, _ = self._between(-math.inf, math.inf)
        return (min(float(times[0]), self._pinned[0]), float(times[-1])) if len(times) else None

    @property
    def longest_step(self) -> float:
        """How far apart samples of one line may be, s: as the latest have told, or those before."""
        if self._longest_step is None:
            latest = self.ring.latest(_USUAL)
            self._longest_step = timestamp_source.longest_step(self.stream.path, latest)
        return self._longest_step

    def age(self, now: float) -> Optional[float]:
        """Return how long ago its last sample was taken, s; None where there is none.

        :param now: the time, s
        """
        latest = self.ring.latest(1)
        return now - float(latest[0]) - self.stream.offset if len(latest) else None

    def _between(self, start: float, end: float) -> Tuple[numpy.ndarray, ...]:
        # Sought with some more, as the ends are rounded otherwise than the samples' times.
        offset = self.stream.offset
        if self._pinned[0] <= (start + end) / 2.0 <= self._pinned[1]:
            # The clocks may have gone apart since, as where a simulation is slower.
            offset = self._pinned_offset
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
