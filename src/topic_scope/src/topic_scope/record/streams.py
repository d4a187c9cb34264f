"""What comes of a topic, and the time that its messages go by."""

from typing import List, Optional, Tuple

import numpy

from topic_scope.messages import fields, timestamp_source
from topic_scope.messages.decoding import Decoder
from topic_scope.messages.definitions import Record
from topic_scope.record.message_source import Batch
from topic_scope.record.traces import Trace, decoder_of


class Stream:
    """Traces of one topic that go by one time.

    :param topic: the topic
    :param timestamp: name of the time; see :func:`.timestamp_source.path_of`

    :ivar traces: those that are recorded
    """

    def __init__(self, topic: str, timestamp: str) -> None:
        self.topic = topic
        self.traces: List[Trace] = []
        self._timestamp = timestamp
        self._layout: Optional[Record] = None
        self._path: Optional[fields.Path] = None
        self._decoder: Optional[Decoder] = None
        self._latest: Optional[Tuple[List[bytes], numpy.ndarray, numpy.ndarray]] = None
        self._time = timestamp_source.OwnClock(None)

    @property
    def offset(self) -> float:
        """What is to be added to the times in the rings to get the scope's, s."""
        return self._time.offset

    @property
    def path(self) -> Optional[fields.Path]:
        """Where the time stands in the messages, None where that of receipt is in use."""
        return self._path if self._time.is_said else None

    @property
    def timestamp(self) -> str:
        """The name of the time that is in use."""
        return timestamp_source.name_of(self.path)

    def record(self, path: fields.Path, history: float, function: str = "") -> Trace:
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
        :returns: the time of the earliest one, s; minus infinity where earlier samples have moved
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
        except fields.FieldError:  # the topic has got another type
            path = None
        if path != self._path:
            for trace in self.traces:  # what is there goes by the scope's clock from now on
                trace.move(self.offset)
            self._time = timestamp_source.OwnClock(path)
        self._path = path
        self._decoder = None if path is None else decoder_of(layout, path)
        for trace in self.traces:
            trace.read_as(layout)
