"""Records the fields that are looked at: from names to samples."""

from typing import Collection, Dict, List, Mapping, NamedTuple, Optional, Tuple

import numpy

from topic_scope import decoding, fields
from topic_scope.decoding import Decoder
from topic_scope.definitions import Record
from topic_scope.layouts import Layouts
from topic_scope.ring import Ring, Samples
from topic_scope.taps import Batch, Taps

#: Most fields that are listed, and most topics that are listened to just to learn their type.
LISTED, UNKNOWN = 5000, 50
#: Most traces that are recorded; beyond that, those that nobody looks at any more are forgotten.
TRACES = 1024
#: Most arrays of a topic whose lengths are remembered.
_ARRAYS = 1000

_NOTHING: Samples = (numpy.empty(0), numpy.empty(0))


class Choice(NamedTuple):
    """A field that can be chosen.

    :param field: its name
    :param datatype: its type, e.g. ``float32``
    """

    field: str
    datatype: str


class _Longest:
    """How many elements the arrays of a topic have had at most, so that the list stands still."""

    def __init__(self) -> None:
        self._known: Dict[fields.Path, int] = {}
        self._latest: fields.Lengths = fields.one_element

    def look(self, layout: Record, message: bytes) -> None:
        """Take the lengths from a message."""
        self._latest = decoding.lengths_in(layout, message)

    def __call__(self, path: fields.Path) -> int:
        try:
            latest = self._latest(path)
        except fields.FieldError:  # the topic has got another type
            latest = 1
        longest = max(latest, self._known.get(path, 0))
        if path in self._known or len(self._known) < _ARRAYS:
            self._known[path] = longest
        return longest


class _Trace:
    """The samples of one field.

    :param topic: its topic
    :param path: where it stands in a message
    :param history: how long samples are kept, s
    """

    def __init__(self, topic: str, path: fields.Path, history: float) -> None:
        self.topic = topic
        self.path = path
        self.ring = Ring(history)
        self.used_at = 0.0
        self._layout: Optional[Record] = None
        self._decoder: Optional[Decoder] = None

    def add(self, layout: Record, batch: Batch) -> None:
        if layout is not self._layout:
            self._layout = layout
            try:
                self._decoder = Decoder(layout, self.path)
            except fields.FieldError:  # the topic has got another type
                self._decoder = None
        if self._decoder is not None:
            values = self._decoder.decode(batch.messages)
            self.ring.append(numpy.array(batch.times), values)


class Recorder:
    """Keeps the recent samples of the fields that are wanted.

    All methods belong to one thread.

    :param taps: where the messages come in
    :param layouts: knows the messages
    :param history: how long samples are kept, and a field that nobody looks at any more, s
    """

    def __init__(self, taps: Taps, layouts: Layouts, history: float) -> None:
        self.history = history
        self._taps = taps
        self._layouts = layouts
        self._types: Mapping[str, str] = {}
        self._lengths: Dict[str, "_Longest"] = {}
        self._choices: Dict[Tuple[str, str], List[Choice]] = {}
        self._traces: Dict[str, _Trace] = {}
        self._by_topic: Dict[str, List[_Trace]] = {}

    def set_topics(self, types: Mapping[str, str]) -> None:
        """Take note of what there is on the graph.

        :param types: type of each published topic
        """
        self._types = types

    def choices(self) -> List[Choice]:
        """List the fields that can be chosen now."""
        # What nobody looks at stays as it is: listing it again would cost more than all else.
        known, self._choices = self._choices, {}
        for topic, datatype in sorted(self._types.items(), key=_rank):
            layout = self._layouts.installed(datatype)
            if layout is None:
                continue
            if topic in self._by_topic or (topic, datatype) not in known:
                lengths = self._lengths.get(topic, fields.one_element)
                listed = fields.numeric_fields(layout, lengths)
                known[topic, datatype] = [
                    Choice(_name(topic, field.path), field.datatype) for field in listed
                ]
            self._choices[topic, datatype] = known[topic, datatype]
        return [choice for listed in self._choices.values() for choice in listed][:LISTED]

    def _unknown(self) -> List[str]:
        """List topics whose type is not installed: their first message will tell what it is."""
        types = self._types.items()
        return [topic for topic, name in types if not self._layouts.installed(name)][:UNKNOWN]

    def expand(self, name: str) -> List[str]:
        """Return the names of all numeric fields that a name stands for.

        :param name: of a field, of a part of a message or of a topic
        :returns: the name itself, as long as its topic is not known
        :raises FieldError: if its topic has no such field
        """
        place = fields.split(name, self._types)
        layout = self._layouts.installed(self._types[place[0]]) if place else None
        if place is None or layout is None:
            return [name]
        topic, text = place
        lengths = self._lengths.get(topic, fields.one_element)
        return [_name(topic, field.path) for field in fields.resolve(layout, text, lengths)]

    def want(self, names: Collection[str], now: float) -> None:
        """Record these fields; those that were wanted before stay for the time of the history.

        :param names: names that :meth:`expand` has returned
        :param now: the time, s
        """
        for name in names:
            trace = self._traces.get(name) or self._new_trace(name)
            if trace is not None:
                self._traces[name] = trace
                trace.used_at = now
        recent = sorted(self._traces.items(), key=lambda item: item[1].used_at)[-TRACES:]
        self._traces = {name: one for name, one in recent if one.used_at >= now - self.history}
        self._by_topic = {}
        for trace in self._traces.values():
            self._by_topic.setdefault(trace.topic, []).append(trace)
        self._taps.want(list(self._by_topic) + self._unknown())

    def _new_trace(self, name: str) -> Optional[_Trace]:
        place = fields.split(name, self._types)
        if place is None or not place[1]:
            return None  # its topic is not there yet
        return _Trace(place[0], fields.to_path(place[1]), self.history)

    def update(self) -> float:
        """Take in what has come.

        :returns: the time up to which all samples are there, s
        """
        now = self._taps.clock.now()
        for topic, tap in self._taps.open().items():
            for batch in tap.take():
                layout = self._layouts.received(batch.header)
                if layout is None:
                    continue
                self._lengths.setdefault(topic, _Longest()).look(layout, batch.messages[-1])
                for trace in self._by_topic.get(topic, ()):
                    trace.add(layout, batch)
        return now

    def samples(self, name: str, start: float, end: float) -> Samples:
        """Return the samples of a field.

        :param name: its name
        :param start: begin of the span, s
        :param end: end of the span, s
        """
        trace = self._traces.get(name)
        return trace.ring.between(start, end) if trace else _NOTHING

    def topic_of(self, name: str) -> str:
        """Return the topic of a field, empty where it is not known."""
        return self._traces[name].topic if name in self._traces else ""


def _rank(item: Tuple[str, str]) -> Tuple[bool, str]:
    """Return what topics are sorted by: what nodes tell of their parameters comes last."""
    topic, datatype = item
    return datatype.startswith("dynamic_reconfigure/"), topic


def _name(topic: str, path: fields.Path) -> str:
    return f"{topic}/{fields.to_text(path)}"
