"""Selection of a bag's fields and formulas by name, as columns or plot lines."""

import difflib
from functools import partial
from typing import Collection, Dict, List, Mapping, NamedTuple, Optional, Tuple

from topic_scope.bag.message_slices import FirstMessage
from topic_scope.formulas.names import expand_with, formula_of
from topic_scope.formulas.parser import Formula
from topic_scope.messages.arrays import keys_in, lengths_in, with_names
from topic_scope.messages.field_functions import STATE
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

#: Least similarity of a suggested name, from 0 to 1; most suggestions.
_ALIKE, _HINTS = 0.7, 3


class Column(NamedTuple):
    """Numeric field of a topic.

    :param topic: global name of the topic
    :param path: path of the number in a message
    :param timestamp: name of its timestamp source; see :func:`.timestamp_source.path_of`
    :param function: name of the function applied to it; see :mod:`.field_functions`
    :param field: name of the number, if its default name could also denote another topic of the bag
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
    """Return the columns that a list of names denotes, without duplicates.

    :param expressions: names in the notation of :mod:`topic_scope.messages.fields`
    :param first_messages: as :func:`.first_messages` returns them
    :raises FieldError: if there is no such number; the text suggests similar names
    """
    columns: List[Column] = []
    for expression in expressions:
        for name in expand(expression):
            columns += _columns(name, first_messages)
    return list(dict.fromkeys(columns))


class Line(NamedTuple):
    """Line of a plot, or column of a file.

    :param name: its name
    :param columns: the numbers that it is computed from
    :param formula: its formula, by their names; None for a single column
    """

    name: str
    columns: Tuple[Column, ...]
    formula: Optional[Formula] = None


def choose_lines(expressions: List[str], first_messages: Mapping[str, FirstMessage]) -> List[Line]:
    """Return the lines that a list of names denotes, fields and formulas, without duplicates.

    :param expressions: as for :func:`choose`, formulas, or differences
    :param first_messages: as :func:`.first_messages` returns them
    :raises FieldError: as :func:`choose`, and if a formula is invalid
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
    """Return all numeric fields that :func:`.numeric_fields` lists.

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
            raise FieldError("no such topic")
        topic, rest = parts
        layout, data = first_messages[topic]
        path_of(timestamp, layout)
        function = STATE if not function and is_text(layout, rest) else function
        found = [field.path for field in resolve(layout, rest, lengths_in(layout, data), function)]
        typed, names_at = to_path(rest), partial(keys_in, layout, data)
        if found != [typed]:  # a name that denotes a part of a message: name its elements
            found = [with_names(path, names_at, len(typed)) for path in found]
    except FieldError as error:
        known = [column.name for column in all_columns(first_messages)]
        raise FieldError(f"{name}: {error}; {_hint(bare, known, first_messages)}") from error
    return [
        Column(topic, path, timestamp, function, _field(topic, path, first_messages))
        for path in found
    ]


def _field(topic: str, path: Path, topics: Collection[str]) -> str:
    """Return an unambiguous name of a number; empty if its default name is unambiguous."""
    name = name_of(topic, path, topics)
    return "" if name == name_of(topic, path, (topic,)) else name


def _hint(name: str, known: List[str], topics: Collection[str]) -> str:
    """Return suggestions for an unknown name."""
    if not known:
        return "the bag has no numbers"
    place = split(name, topics)
    own = [other for other in known if place and _topic(other, topics) == place[0]]
    near = sorted(
        (other for other in known if _likeness(name, other) > _ALIKE),
        key=lambda other: (other not in own, -_likeness(name, other)),
    )
    if near or own:
        return f"similar names: {', '.join((near or own)[:_HINTS])}"
    with_numbers = sorted({_topic(other, topics) for other in known})
    more = ", …" if len(with_numbers) > _HINTS else ""
    return f"topics with numbers: {', '.join(with_numbers[:_HINTS])}{more}"


def _topic(name: str, topics: Collection[str]) -> str:
    place = split(name, topics)
    return place[0] if place else name


def _likeness(name: str, other: str) -> float:
    """Return the similarity of two names, or of their last parts: one may lack its topic."""
    last, other_last = (one.rpartition("/")[2] for one in (name, other))
    return max(
        difflib.SequenceMatcher(None, name, other).ratio(),
        difflib.SequenceMatcher(None, last, other_last).ratio() - 0.1,
    )
