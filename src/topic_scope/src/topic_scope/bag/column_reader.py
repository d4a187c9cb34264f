"""Reader of one field's numbers and stamps from a bag's messages, and a CSV writer."""

import math
import struct
from typing import Any, Iterable, Iterator, List, Optional, Sequence, TextIO, Union

import numpy

from topic_scope.analysis.csv_rows import CsvColumn, header, quoted, rows
from topic_scope.bag.columns import Column
from topic_scope.bag.message_slices import FirstMessage, Slice
from topic_scope.messages.arrays import first_missing, lengths_in, missing_text
from topic_scope.messages.decoding import Decoder, ElementMissing, rounding_text
from topic_scope.messages.field_functions import STATE, make, parts
from topic_scope.messages.fields import Key, FieldError, to_text
from topic_scope.messages.states import StateDecoder, StateTable
from topic_scope.messages.timestamp_source import is_exact, path_of, read_times, topic_time
from topic_scope.timing.clocks import ELSEWHERE_NS, Clocks
from topic_scope.timing.nanoseconds import NO_TIME, exact_seconds
from topic_scope.timing.topic_time import AHEAD_NS, TopicTime

#: Value for a message that ends before the field.
_CUT_OFF = object()


class ColumnReader:
    """Reader of a column; records whether any message contained the field.

    :param column: the column
    :param first: an early message of the topic, with its layout
    :param begin: start of the bag, ns since the epoch

    :ivar column: the column
    :ivar stamp_path: path of the stamp in a message; None if the time of receipt is used
    """

    def __init__(self, column: Column, first: FirstMessage, begin: int) -> None:
        self.column = column
        #: Start of the bag [ns] since the epoch.
        self.begin = begin
        self.stamp_path = path_of(column.timestamp, first.layout)
        #: Whether samples are placed at their stamps, however late they were recorded.
        self.is_exact = is_exact(column.timestamp, first.layout)
        self._layout = first.layout
        stamp = self.stamp_path
        self._stamp = Decoder(self._layout, stamp) if stamp is not None else None
        paths = [column.path + part for part in parts(column.function)]
        #: Texts of the state numbers in the rows; None for a numeric column.
        self.states = StateTable() if column.function == STATE else None
        self._decoders: Sequence[Union[Decoder, StateDecoder]] = (
            [Decoder(self._layout, path) for path in paths]
            if self.states is None
            else [StateDecoder(self._layout, column.path, self.states)]
        )
        self._function = make(column.function)
        #: Whether the path names an element; messages without that element are ignored.
        self._is_named = any(isinstance(part, Key) for part in column.path)
        #: Rounding step of integers that a float cannot represent exactly.
        self.rounding = 1
        #: Whether the field was found; a field without elements is in each message.
        self._was_there = not any(isinstance(part, (int, Key)) for part in column.path)
        #: Longest array seen, and the text for a missing field.
        self._longest = -1
        self._missing = "not in any message"
        self._cut_off = 0

    @property
    def cut_off(self) -> Optional[str]:
        """Count of messages that end before the field, as text; None without any."""
        count = self._cut_off
        return f"{count} message{'s' * (count > 1)} cut off: left out" if count else None

    @property
    def correction(self) -> Optional[str]:
        """Rounding and missing values, as text; None without any."""
        note = self.states.note if self.states is not None else None
        return "; ".join(filter(None, (rounding_text(self.rounding), self.cut_off, note))) or None

    def check(self) -> None:
        """Check that at least one message contained the field.

        :raises FieldError: if none did
        """
        if not self._was_there:
            raise FieldError(f"{self.column.name}: {self._missing}")

    def rows(self, messages: List[bytes]) -> numpy.ndarray:
        """Return a row for each number that the column is computed from; NaN if missing."""
        rows = numpy.array([decoder.decode(messages) for decoder in self._decoders])
        for decoder, row in zip(self._decoders, rows):
            self.rounding = max(self.rounding, decoder.rounding(row))
        unknown = numpy.flatnonzero(numpy.isnan(rows).any(axis=0)).tolist()
        for index in unknown:
            values = [self._value(decoder, messages[index]) for decoder in self._decoders]
            self._cut_off += _CUT_OFF in values
        self._was_there = self._was_there or len(unknown) < len(messages)
        return rows

    def topic_time(self, clocks: Clocks) -> TopicTime:
        """Return the object that places the messages of the topic in time.

        :param clocks: clocks of all topics of the bag
        """
        return topic_time(clocks, self.column.timestamp, self._layout)

    def stamps(self, messages: List[bytes]) -> numpy.ndarray:
        """Return the stamps of messages [ns]; NO_TIME for an unset stamp."""
        if self._stamp is None or self.stamp_path is None:
            return numpy.full(len(messages), NO_TIME)
        return read_times(self._stamp, self.stamp_path, messages)

    def about(self, messages: List[bytes]) -> "numpy.ndarray":
        """Return a mask of the messages that contain the named element."""
        if not self._is_named:
            return numpy.ones(len(messages), bool)
        decoder = self._decoders[0]
        return numpy.array([self._value(decoder, message) is not None for message in messages])

    def cells(self, found: Slice) -> CsvColumn:
        """Return the cells of messages, exactly as recorded.

        Rows are placed at the stamps if the name selects them, else at the time of recording;
        rows of a derivative in the middle of two messages.
        """
        times = self._stamps_ns(found) if self.is_exact else found.times
        places = numpy.arange(len(found.messages))
        if not self.column.function or self.states is not None:
            return CsvColumn(self.column.topic, times, places, list(self._texts(found.messages)))
        by_rows = self._stamp is None or self.is_exact
        own = times if by_rows else self.stamps(found.messages)
        made, values = self._function(own, self.rows(found.messages), math.inf)
        # A value computed from two messages starts at the second; a derivative lies between both.
        late = len(places) - len(values)
        texts = [repr(value) for value in values.tolist()]
        return CsvColumn(self.column.topic, times[late:] - own[late:] + made, places[late:], texts)

    def _stamps_ns(self, found: Slice) -> numpy.ndarray:
        """Return the stamps, or else the times of recording, since the start of the bag [ns]."""
        stamps = self.stamps(found.messages)
        ahead = stamps - self.begin - found.times
        # An unset stamp, an implausible stamp, or a stamp of another clock.
        said = (stamps != NO_TIME) & (ahead > -ELSEWHERE_NS) & (ahead <= AHEAD_NS)
        return numpy.where(said, stamps - self.begin, found.times)

    def _texts(self, messages: List[bytes]) -> Iterator[str]:
        (decoder,) = self._decoders
        for message in messages:
            value = self._value(decoder, message)
            if value is None or value is _CUT_OFF:
                self._cut_off += value is _CUT_OFF
                yield ""
            elif isinstance(value, str):
                yield quoted(value)
            elif decoder.is_time:
                yield exact_seconds(value)
            else:
                yield repr(int(value) if isinstance(value, bool) else value)

    def _value(self, decoder: Union[Decoder, StateDecoder], message: bytes) -> Any:
        """Return a number or state unchanged; None if an element of its path is missing."""
        try:
            value = decoder.value(message)
        except struct.error:
            return _CUT_OFF
        except ElementMissing:
            if not self._was_there:
                self._explain(message)
            return None
        self._was_there = True
        return value

    def _explain(self, message: bytes) -> None:
        place, part = first_missing(self._layout, self.column.path, message)
        if isinstance(part, Key):
            self._missing = missing_text(place, part)
        elif part is not None:
            self._longest = max(self._longest, lengths_in(self._layout, message)(place))
            self._missing = f"{to_text(place)} has {self._longest} elements at most"


def write_csv(file: TextIO, readers: List[ColumnReader], slices: Iterable[List[Slice]]) -> None:
    """Write a row for each message: its time [s], and its numbers.

    Cells of other topics, and of elements that an array is too short for, are empty.

    :param file: the output
    :param readers: readers of the columns
    :param slices: the messages
    """
    file.write(header("time", *(reader.column.name for reader in readers)))
    for found in slices:
        of_topic = {one.topic: one for one in found}
        columns = [
            reader.cells(of_topic.get(reader.column.topic, Slice.empty(reader.column.topic)))
            for reader in readers
        ]
        file.writelines(rows(columns, lambda time, _index: exact_seconds(time)))
