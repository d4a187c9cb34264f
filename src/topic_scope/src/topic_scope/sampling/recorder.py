"""Recorder of the fields that pages show: expands their names, and keeps recent samples."""

import itertools
import math
from collections import deque
from typing import (
    Any,
    Collection,
    Deque,
    Dict,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Set,
    Tuple,
)

import numpy

from topic_scope.analysis.ring import Samples
from topic_scope.formulas.names import expand_with, formula_of, problem_of, terms
from topic_scope.messages import fields, timestamp_source
from topic_scope.messages.arrays import Arrays, has_names
from topic_scope.messages.message_layout import MessageLayout
from topic_scope.messages.field_functions import STATE
from topic_scope.messages.layout_cache import Layouts
from topic_scope.sampling.computed_trace import ComputedTrace, Recorded
from topic_scope.sampling.image_history import ImageHistory, histories
from topic_scope.sampling.overlay_trace import OverlayTrace, Overlay
from topic_scope.sampling.message_source import Batch, MessageSource
from topic_scope.sampling.streams import Streams
from topic_scope.sampling.traces import Stream, Trace
from topic_scope.timing.nanoseconds import NS, to_ns

#: Most listed fields, and most topics that are subscribed to for a single message.
LISTED, UNKNOWN = 5000, 50
#: Most recorded traces; if there are more, traces that no page shows are dropped.
TRACES = 1024
#: Number of updates that are stored for pages that have not had a frame since.
_UPDATES = 400

_LOGS = ("rosgraph_msgs/Log", "rosgraph_msgs/TopicStatistics")
_NEVER = (math.inf, -math.inf)
_NOTHING: Samples = (numpy.empty(0), numpy.empty(0))


class OfferedField(NamedTuple):
    """Field offered for selection.

    :param field: its name
    :param datatype: its type, e.g. ``float32``
    :param topic: its topic
    """

    field: str
    datatype: str
    topic: str


class Recorder:
    """Recorder of the recent samples of the requested fields.

    All methods are for one thread.

    :param source: source of the messages
    :param layouts: layouts of the messages
    :param history: how long samples, and fields that no page shows, are kept [s]
    :param overlays: the overlaid bags, whose topics are added to those of the source
    """

    def __init__(
        self,
        source: MessageSource,
        layouts: Layouts,
        history: float,
        overlays: Sequence[Overlay] = (),
    ) -> None:
        self.history = history
        self._source = source
        self._layouts = layouts
        self._types: Mapping[str, str] = {}
        self._overlaid = {topic: overlay for overlay in overlays for topic in overlay.layouts}
        self._arrays = {topic: one.arrays[topic] for topic, one in self._overlaid.items()}
        #: The latest message of each subscribed topic: a latched message arrives only once.
        self._latest: Dict[str, Tuple[MessageLayout, Batch]] = {}
        self._choices: Dict[Tuple[str, str, bool], List[OfferedField]] = {}
        self._traces: Dict[str, Trace] = {}
        #: Streams of the topics, with the chosen clocks.
        self.streams = Streams()
        self._images: Dict[str, ImageHistory] = {}
        #: Time up to which each shown formula was known at the latest update [s].
        self._known: Dict[str, float] = {}
        #: Times of the latest updates, and of the earliest sample that each added [s].
        self._updates: Deque[Tuple[float, float]] = deque(maxlen=_UPDATES)

    def set_topics(self, types: Mapping[str, str]) -> None:
        """Update the topics and their types."""
        self._types = types
        kept = {*types, *self.streams.topics}
        self._arrays = {topic: one for topic, one in self._arrays.items() if topic in kept}

    def choices(self) -> List[OfferedField]:
        """List the available fields."""
        # Only shown topics are listed again: listing all would dominate the cost.
        known, self._choices = self._choices, {}
        recorded = set(self.streams.topics)
        for topic, datatype in sorted(self._types.items(), key=_rank):
            layout = self._layout_of(topic)
            if layout is None:
                continue
            key = (topic, datatype, topic in self._arrays)
            if topic in recorded or key not in known:
                known[key] = self._listed(topic, layout)
            self._choices[key] = known[key]
        return [choice for listed in self._choices.values() for choice in listed][:LISTED]

    def _listed(self, topic: str, layout: MessageLayout) -> List[OfferedField]:
        arrays = self._arrays.get(topic, Arrays())
        found = [(field, "") for field in fields.numeric_fields(layout, arrays)]
        found += [(field, ".yaw") for field in fields.quaternions(layout, arrays)]
        found += [(field, f".{STATE}") for field in fields.states(layout, arrays)]
        choices = (
            OfferedField(fields.name_of(topic, path, self._types) + end, field.datatype, topic)
            for field, end in found
            for path in arrays.named(field.path)
        )
        return list(dict.fromkeys(choices))

    def _unknown_topics(self) -> List[str]:
        """List topics whose type, or names of elements, require a first message."""
        unknown = []
        for topic in self._types:
            layout = self._layout_of(topic)
            if layout is None or (topic not in self._arrays and has_names(layout)):
                unknown.append(topic)
        return unknown[:UNKNOWN]

    def _layout_of(self, topic: str) -> Optional[MessageLayout]:
        """Return the layout of the messages of an existing topic; None if unknown."""
        laid = self._overlaid.get(topic)
        return laid.layouts[topic] if laid else self._layouts.installed(self._types[topic])

    def expand(self, name: str) -> List[str]:
        """Return the names of all numeric fields that a name denotes.

        :param name: name of a field, of a part of a message or of a topic, or a formula
        :returns: the name itself while its topic is unknown
        :raises FieldError: if the name is invalid, or its topic does not have the field
        """
        problem = problem_of(name)
        if problem:
            raise fields.FieldError(problem)
        return expand_with(name, self._expand_term)

    def _expand_term(self, name: str) -> List[str]:
        bare, function, timestamp = fields.parted(name)
        place = fields.split(bare, self._types)
        layout = self._layout_of(place[0]) if place else None
        if place is None or layout is None:
            return [name]
        topic, text = place
        timestamp_source.path_of(timestamp, layout)
        if not function and fields.is_text(layout, text):
            return self._expand_term(bare + fields.ending(STATE, timestamp))
        arrays = self._arrays.get(topic, Arrays())
        found = [field.path for field in fields.resolve(layout, text, arrays, function)]
        typed = fields.to_path(text)
        if found != [typed]:  # for a part of a message, use the listed names
            found = [one for path in found for one in arrays.remembered(path, len(typed))]
        names = [fields.name_of(topic, path, self._types) for path in dict.fromkeys(found)]
        return [one + name[len(bare) :] for one in names]

    def want(self, names: Collection[str], now: float) -> None:
        """Record these fields; earlier fields are kept for the time of the history.

        :param names: names that :meth:`expand` has returned or rejected; the latter have no samples
        :param now: the time [s]
        """
        wanted = {part for name in names for part in terms(name)}
        self._known = {name: self._known.get(name, -math.inf) for name in names if formula_of(name)}
        new = wanted - self._traces.keys()
        for name in new:
            self._record(name)
        for name in self._traces.keys() & wanted:
            self._traces[name].used_at = now
        recent = sorted(self._traces.items(), key=lambda item: item[1].used_at)[-TRACES:]
        self._traces = {name: one for name, one in recent if one.used_at >= now - self.history}
        begun = (self._traces.get(name) for name in new)
        self._request(any(type(one) is Trace for one in begun))

    def want_images(self, topics: Collection[str]) -> None:
        """Record the images of these topics, and of no others."""
        known = {*self._types, *self._images} - self._overlaid.keys()
        before = self._images
        self._images = histories(known & set(topics), before, self.history)
        new = self._images.keys() - before.keys()
        self._attach_images(new)
        self._request(bool(new))

    def _attach_images(self, topics: Collection[str]) -> None:
        for topic in topics:
            stream = self.streams.get(topic)
            stream.attach(self._images[topic])
            self._repeat_latest(stream)

    def _request(self, is_more: bool) -> None:
        """Request the messages of all traces and images, and drop other streams.

        :param is_more: whether there are new traces or images
        """
        recorded: Set[Any] = {*self._traces.values(), *self._images.values()}
        self.streams.keep(recorded)
        self._source.want(self.streams.topics + self._unknown_topics(), is_more)

    def forget(self) -> None:
        """Drop all samples: the clock has jumped."""
        self.streams.restart()
        traces = self._traces
        self._traces = {name: one for name, one in traces.items() if isinstance(one, OverlayTrace)}
        self._updates.clear()
        self._latest.clear()
        for name in traces:
            if name not in self._traces:
                self._record(name)
        self._images = histories(self._images, {}, self.history)
        self._attach_images(self._images)
        self._known = dict.fromkeys(self._known, -math.inf)

    def pin(self, spans: Mapping[str, Tuple[float, float]]) -> None:
        """Keep the samples of fields in these spans until the next call.

        :param spans: start and end by name of the field [s]
        """
        pinned: Dict[str, Tuple[float, float]] = {}
        for name, (start, end) in spans.items():
            trace = self.trace(name)
            # Interpolation needs the samples on both sides.
            back, ahead = trace.lookaround if isinstance(trace, ComputedTrace) else (0.0, 0.0)
            for part in terms(name):
                before = pinned.get(part, (start, end))
                pinned[part] = min(start - back, before[0]), max(end + ahead, before[1])
        for name, trace in self._traces.items():
            trace.pin(*pinned.get(name, _NEVER))

    def _record(self, name: str) -> None:
        bare, function, timestamp = fields.parted(name)
        place = fields.split(bare, self._types)
        if problem_of(name) or place is None or not (place[1] or function):
            return  # the name is invalid, or its topic does not exist yet
        path = fields.to_path(place[1])
        if place[0] in self._overlaid:
            laid = self._overlaid[place[0]]
            self._traces[name] = laid.trace(place[0], path, timestamp, function)
            return
        stream = self.streams.get(place[0], timestamp)
        self._traces[name] = stream.record(path, self.history, function)
        self._repeat_latest(stream)

    def _repeat_latest(self, stream: Stream) -> None:
        """Add the latest message to a new stream: a latched message arrives only once."""
        if not stream.has_begun and stream.topic in self._latest:
            stream.add(*self._latest[stream.topic])

    def is_known(self, topic: str) -> bool:
        """Return whether a topic exists."""
        return topic in self._types

    def is_overlaid(self, topic: str) -> bool:
        """Return whether a topic belongs to an overlaid bag."""
        return topic in self._overlaid

    def images(self, topic: str) -> Optional[Tuple[ImageHistory, Stream]]:
        """Return the images of a topic and their stream; None if they are not recorded."""
        images = self._images.get(topic)
        return None if images is None else (images, self.streams.get(topic))

    def update(self) -> float:
        """Read new messages from the source.

        :returns: the time up to which samples are complete [s]
        """
        now = self._source.clock.now()
        earliest, changes = now, self.streams.clocks.changes
        subscriptions = self._source.subscriptions()
        self._latest = {topic: one for topic, one in self._latest.items() if topic in subscriptions}
        streams: Dict[str, List[Stream]] = {}
        for stream in self.streams:
            streams.setdefault(stream.topic, []).append(stream)
        for topic, subscription in subscriptions.items():
            for batch in subscription.drain():
                layout = self._layouts.received(batch.header)
                if layout is None:
                    continue
                arrays = self._arrays.setdefault(topic, Arrays())
                arrays.add_message(layout, batch.messages[-1], batch.times[-1] / NS)
                latest = Batch(batch.header, batch.times[-1:], batch.messages[-1:])
                self._latest[topic] = (layout, latest)
                for stream in streams.get(topic, []):
                    earliest = min(earliest, stream.add(layout, batch))
        moment = to_ns(math.inf if self._source.has_ended else now)
        for stream in self.streams:
            earliest = min(earliest, stream.release(moment))
        if self.streams.clocks.changes != changes:  # all topics of the clock have shifted
            earliest = -math.inf
        for name, known in self._known.items():
            trace = self.trace(name)
            if not isinstance(trace, ComputedTrace):
                continue
            if earliest < known:  # late samples also affect earlier values
                earliest -= max(trace.lookaround[1], 0.0)
            until = min(trace.until, now)
            if until > known:
                # Earlier samples of the first trace have become known only now.
                earliest = min(earliest, known)
                self._known[name] = until
        self._updates.append((now, earliest))
        return now

    @property
    def updated(self) -> float:
        """Time of the latest update [s]."""
        return self._updates[-1][0] if self._updates else -math.inf

    def changed_since(self, moment: float) -> float:
        """Return the time from which on samples may have changed [s].

        :param moment: a time that :meth:`update` returned; all later samples are new
        """
        if not self._updates or moment < self._updates[0][0]:
            return -math.inf
        new = itertools.takewhile(lambda update: update[0] > moment, reversed(self._updates))
        return min([moment, *(earliest for _, earliest in new)])

    def samples(self, name: str, start: float, end: float) -> Samples:
        """Return the samples of a field or a formula in a time span [s]."""
        trace = self.trace(name)
        return trace.samples(start, end) if trace else _NOTHING

    def longest_step(self, name: str) -> float:
        """Return the longest time between connected samples of a field [s]."""
        trace = self._traces.get(terms(name)[0])
        return trace.longest_step if trace else math.inf

    def problem(self, name: str) -> Optional[str]:
        """Return why a field has no samples, as text; None if no reason is known."""
        if formula_of(name) is None:
            return problem_of(name) or self._problem_of_term(name)
        problems = [(part, self._problem_of_term(part)) for part in terms(name)]
        found = next((f"{part}: {text}" for part, text in problems if text), None)
        trace = self.trace(name)
        return trace.problem if found is None and isinstance(trace, ComputedTrace) else found

    def _problem_of_term(self, name: str) -> Optional[str]:
        place = fields.split(fields.parted(name)[0], self._types)
        if place is None:
            trace = self._traces.get(name)
            return None if trace is not None and trace.span else "the topic does not exist yet"
        layout, trace = self._layout_of(place[0]), self._traces.get(name)
        try:
            if trace is None or not trace.is_read:
                self.expand(name)
            if isinstance(trace, OverlayTrace):
                return trace.problem
            if layout is None:
                return self._layouts.problem(self._types[place[0]])
            if place[0] in self._arrays:
                self._arrays[place[0]].check(layout, fields.to_path(place[1]))
        except fields.FieldError as error:
            return str(error)
        return None

    def trace(self, name: str) -> Optional[Recorded]:
        """Return the recorded or computed trace of a name; None without one."""
        formula = formula_of(name)
        if formula is None:
            return self._traces.get(name)
        if not self._traces.keys() >= set(formula.fields):
            return None
        return ComputedTrace(formula, self._traces)


def _rank(item: Tuple[str, str]) -> Tuple[bool, str]:
    """Return the sort key of topics: log and status topics of nodes are last."""
    topic, datatype = item
    return datatype.startswith("dynamic_reconfigure/") or datatype in _LOGS, topic
