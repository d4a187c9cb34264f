"""Selection of numbers from a bag's messages by their names."""

import difflib
from functools import partial
from typing import Collection, Dict, List, Mapping, NamedTuple, Optional, Tuple

from topic_scope.bag.message_slices import FirstMessage
from topic_scope.formulas.names import expand_with, formula_of
from topic_scope.formulas.parser import Formula
from topic_scope.messages.derived import STATE
from topic_scope.messages.arrays import keys_in, lengths_in, with_names
from topic_scope.messages.fields import (
    FieldError,
    Path,
    ending,
    expand,
    is_text,
    name_of,
    numeric_fields,
    parted,
    resolve,
    split,
    to_path,
)
from topic_scope.messages.timestamp_source import path_of

#: How alike a name has to be to be named, from 0 to 1; and how many are.
_ALIKE, _HINTS = 0.7, 3


class Column(NamedTuple):
    """A number that the messages of a topic have.

    :param topic: global name of the topic
    :param path: where the number stands in a message
    :param timestamp: name of the time to plot it over; see :func:`.timestamp_source.path_of`
    :param function: name of what is computed of it; see :mod:`.derived`
    :param field: name of the number where the bag has a topic that it could be taken for
    """

    topic: str
    path: Path
    timestamp: str = ""
    function: str = ""
    field: str = ""

    @property
    def name(self) -> str:
        """The name of the field, e.g. ``/signal/signal_y``."""
        field = self.field or name_of(self.topic, self.path, (self.topic,))
        return field + ending(self.function, self.timestamp)


def choose(expressions: List[str], first_messages: Mapping[str, FirstMessage]) -> List[Column]:
    """Return what a list of names stands for, each number once.

    :param expressions: names in the notation of :mod:`topic_scope.messages.fields`
    :param first_messages: as :func:`.first_messages` returns them
    :raises FieldError: if there is no such number; the text names those nearest to it
    """
    columns: List[Column] = []
    for expression in expressions:
        for name in expand(expression):
            columns += _columns(name, first_messages)
    return list(dict.fromkeys(columns))


class Line(NamedTuple):
    """A line of a plot, or a column of a file.

    :param name: its name
    :param columns: the numbers that it is made of
    :param formula: how it is computed of them, by their names; None where it is one of them
    """

    name: str
    columns: Tuple[Column, ...]
    formula: Optional[Formula] = None


def choose_lines(expressions: List[str], first_messages: Mapping[str, FirstMessage]) -> List[Line]:
    """Return what a list of names stands for: numbers, and what is computed of such; each once.

    :param expressions: as for :func:`choose`, formulas, or differences
    :param first_messages: as :func:`.first_messages` returns them
    :raises FieldError: as :func:`choose`, and if a formula is wrong
    """

    def names(field: str) -> List[str]:
        columns = choose([field], first_messages)
        found.update((column.name, column) for column in columns)
        return [column.name for column in columns]

    found: Dict[str, Column] = {}
    lines: Dict[str, Line] = {}
    for expression in expressions:
        for name in expand_with(expression, names):
            formula = formula_of(name)
            fields = formula.fields if formula else (name,)
            lines[name] = Line(name, tuple(found[field] for field in fields), formula)
    return list(lines.values())


def all_columns(first_messages: Mapping[str, FirstMessage]) -> List[Column]:
    """Return all numbers that there are, as far as :func:`.numeric_fields` lists them.

    :param first_messages: as :func:`.first_messages` returns them
    """
    return [
        Column(topic, field.path, field=_field(topic, field.path, first_messages))
        for topic, (layout, data) in sorted(first_messages.items())
        for field in numeric_fields(layout, lengths_in(layout, data))
    ]


def _columns(name: str, first_messages: Mapping[str, FirstMessage]) -> List[Column]:
    bare, function, timestamp = parted(name)
    parts = split(bare, first_messages)
    try:
        if parts is None:
            raise FieldError("there is no such topic")
        topic, rest = parts
        layout, data = first_messages[topic]
        path_of(timestamp, layout)
        function = STATE if not function and is_text(layout, rest) else function
        found = [field.path for field in resolve(layout, rest, lengths_in(layout, data), function)]
        typed, names_at = to_path(rest), partial(keys_in, layout, data)
        if found != [typed]:  # of what stands for a part, elements have their names
            found = [with_names(path, names_at, len(typed)) for path in found]
    except FieldError as error:
        known = [column.name for column in all_columns(first_messages)]
        raise FieldError(f"{name}: {error}; {_hint(bare, known, first_messages)}") from error
    return [
        Column(topic, path, timestamp, function, _field(topic, path, first_messages))
        for path in found
    ]


def _field(topic: str, path: Path, topics: Collection[str]) -> str:
    """Return the name of a number among those of other topics; nothing where its own will do."""
    name = name_of(topic, path, topics)
    return "" if name == name_of(topic, path, (topic,)) else name


def _hint(name: str, known: List[str], topics: Collection[str]) -> str:
    """Return what to ask for in place of a name."""
    if not known:
        return "there are no numbers at all"
    place = split(name, topics)
    own = [other for other in known if place and _topic(other, topics) == place[0]]
    near = sorted(
        (other for other in known if _likeness(name, other) > _ALIKE),
        key=lambda other: (other not in own, -_likeness(name, other)),
    )
    if near or own:
        return f"nearest to it: {', '.join((near or own)[:_HINTS])}"
    with_numbers = sorted({_topic(other, topics) for other in known})
    more = ", …" if len(with_numbers) > _HINTS else ""
    return f"there are numbers in {', '.join(with_numbers[:_HINTS])}{more}"


def _topic(name: str, topics: Collection[str]) -> str:
    place = split(name, topics)
    return place[0] if place else name


def _likeness(name: str, other: str) -> float:
    """Return how alike two names are, or their last parts: one may have lost its topic."""
    last, other_last = (one.rpartition("/")[2] for one in (name, other))
    return max(
        difflib.SequenceMatcher(None, name, other).ratio(),
        difflib.SequenceMatcher(None, last, other_last).ratio() - 0.1,
    )
