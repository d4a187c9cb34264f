"""Bag whose traces are overlaid on those of the scope."""

from typing import Dict, List, Sequence, Tuple

import numpy

from topic_scope.bag.columns import choose
from topic_scope.bag.opening import open_bag
from topic_scope.bag.selected_series import chosen, series_of
from topic_scope.bag.message_slices import first_messages, slices
from topic_scope.bag.series import Series
from topic_scope.formulas.names import formula_of, terms
from topic_scope.messages.arrays import Arrays
from topic_scope.messages.fields import FieldError, Path, ending, name_of, parted, split
from topic_scope.messages.timestamp_source import longest_step, path_of
from topic_scope.sampling.overlay_trace import OverlayStream, OverlayTrace
from topic_scope.timing.nanoseconds import array_to_ns, to_ns


class BagOverlay:
    """Overlaid bag: its topics have a prefix, and its time can be shifted.

    :param path: the file
    :param name: prefix of its topics: ``/signal`` is ``/NAME/signal``
    :param offset: shift to later times, relative to :attr:`begin` [s]
    :raises BagError: if it cannot be read, or has no messages

    :ivar path: the file
    :ivar name: prefix of its topics
    :ivar begin: time of its first message without the offset, by the scope's clock [s]
    :ivar offset: added to :attr:`begin` [s]
    :ivar length: the time from its first to its last message [s]
    :ivar types: type of each of its topics
    :ivar layouts: the same as layouts; see :class:`.Overlay`
    :ivar arrays: arrays in its messages
    :ivar faults: its topics that cannot be read, and why
    """

    def __init__(self, path: str, name: str, offset: float = 0.0) -> None:
        self.path, self.name, self.offset = path, name, offset
        self.begin = 0.0
        with open_bag(path) as bag:
            self.length = bag.length / 1e9
            self._first = first_messages(bag)
            self.faults = bag.faults
        self._prefix = f"/{name}"
        self.layouts = {self._prefix + topic: one.layout for topic, one in self._first.items()}
        self.types = {topic: layout.datatype for topic, layout in self.layouts.items()}
        self.arrays: Dict[str, Arrays] = {topic: Arrays() for topic in self.layouts}
        for topic, one in self._first.items():
            self.arrays[self._prefix + topic].add_message(one.layout, one.data)
        self._wanted: List[Tuple[str, OverlayTrace]] = []

    @property
    def place(self) -> float:
        """Time of its first message by the scope's clock [s]."""
        return self.begin + self.offset

    @property
    def place_ns(self) -> int:
        """The same [ns]."""
        return to_ns(self.place)

    def trace(self, topic: str, path: Path, timestamp: str, function: str) -> OverlayTrace:
        """Return one of its traces, still empty; see :meth:`take_wanted`.

        :param topic: one of :attr:`types`
        :param path: path of the field in a message
        :param timestamp: name of its timestamp source
        :param function: name of the function applied to it
        """
        own = name_of(self._own(topic), path, self._first)
        name = own + ending(function, timestamp)
        time, problem = None, ""
        try:
            choose([name], self._first)
            time = path_of(timestamp, self.layouts[topic])
        except FieldError as error:
            problem = str(error)
        trace = OverlayTrace(OverlayStream(topic, timestamp, time, self), path, function)
        if problem:
            trace.problem = problem
        else:
            self._wanted.append((name, trace))
        return trace

    def take_wanted(self) -> List[Tuple[str, OverlayTrace]]:
        """Return the traces to fill, each once, with their names in the bag."""
        wanted, self._wanted = self._wanted, []
        return wanted

    def name_in_bag(self, name: str) -> str:
        """Return the name of a trace in the bag, for a trace of the bag or of the scope.

        :param name: name of a field, or a formula
        """
        formula = formula_of(name)
        return self._own(name) if formula is None else "=" + formula.text(self._own)

    def longest_step(self, series: Series) -> float:
        """Return the longest time between connected samples [s].

        :param series: a series that :meth:`read` has returned
        """
        bare, _, timestamp = parted(terms(series.name)[0])
        place = split(bare, self._first)
        path = path_of(timestamp, self._first[place[0]].layout) if place else None
        there = numpy.isfinite(numpy.array(series.values))  # NaN marks the end of a line
        return longest_step(path, array_to_ns(numpy.array(series.times)[there]))

    def read(self, names: Sequence[str]) -> List[Series]:
        """Return lines over time; opens the file itself, so any thread may call it.

        :param names: their names in the bag
        :raises FieldError: if there is no such line
        :raises BagError: if the bag is damaged
        """
        with open_bag(self.path) as bag:
            lines, readers = chosen(bag, self._first, names)
            topics = sorted({reader.column.topic for reader in readers})
            return series_of(bag, lines, readers, slices(bag, topics))

    def _own(self, name: str) -> str:
        quote = '"' if name.startswith('"') else ""
        begin = f"{quote}{self._prefix}/"
        return f"{quote}/{name[len(begin) :]}" if name.startswith(begin) else name
