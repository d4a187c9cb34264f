"""Which numbers of a bag's messages were asked for."""

import difflib
from functools import partial
from typing import Any, Collection, Dict, List, Mapping, NamedTuple, Tuple, Union

from topic_scope.messages.arrays import with_names
from topic_scope.messages.definitions import Record, layout_of
from topic_scope.messages.derived import terms
from topic_scope.messages.fields import (
    FieldError,
    Key,
    Path,
    ending,
    expand_term,
    names_of,
    numeric_fields,
    parted,
    resolve,
    split,
    to_path,
    to_text,
)
from topic_scope.messages.timestamp_source import path_of
from topic_scope.messages.values import lengths_in, value_at

#: How alike a name has to be to be named, from 0 to 1; and how many are.
_ALIKE, _HINTS = 0.7, 3


class Column(NamedTuple):
    """A number that the messages of a topic have.

    :param topic: global name of the topic
    :param path: where the number stands in a message
    :param timestamp: name of the time to plot it over; see :func:`.timestamp_source.path_of`
    :param function: name of what is computed of it; see :mod:`.derived`
    """

    topic: str
    path: Path
    timestamp: str = ""
    function: str = ""

    @property
    def name(self) -> str:
        """The name of the field, e.g. ``/signal/signal_y``."""
        field = f"{self.topic}/{to_text(self.path)}" if self.path else self.topic
        return field + ending(self.function, self.timestamp)


class Elements:
    """Watches whether the elements of arrays that were asked for are ever there.

    :param columns: what was asked for
    """

    def __init__(self, columns: Collection[Column]) -> None:
        #: How many elements the array has had at most, or what they are called.
        self._missing: Dict[Column, str] = {
            column: "it is not there"
            for column in columns
            if any(isinstance(part, (int, Key)) for part in column.path)
        }
        self._longest: Dict[Column, int] = {}

    def look(self, topic: str, message: Any) -> None:
        """Take note of a message."""
        for column in [one for one in self._missing if one.topic == topic]:
            if value_at(message, column.path) is not None:
                del self._missing[column]
                continue
            place, part = _first_missing(message, column.path)
            text = to_text(place)
            count = len(value_at(message, place))
            if isinstance(part, Key):
                self._missing[column] = f"none of {text} is called {part}"
            elif count >= self._longest.get(column, 0):
                self._longest[column] = count
                self._missing[column] = f"{text} has {count} elements at most"

    def check(self) -> None:
        """Check that each was there once.

        :raises FieldError: if one was not
        """
        for column, text in self._missing.items():
            raise FieldError(f"{column.name}: {text}")


def _first_missing(message: Any, path: Path) -> "Tuple[Path, Union[str, int]]":
    """Return the array on the way to a place that ends before it, and what it lacks."""
    for position, part in enumerate(path):
        if value_at(message, path[: position + 1]) is None:
            return path[:position], part
    return path[:-1], path[-1]


def choose(expressions: List[str], first_messages: Mapping[str, Any]) -> List[Column]:
    """Return what a list of names stands for, each number once.

    :param expressions: names in the notation of :mod:`topic_scope.messages.fields`
    :param first_messages: a message of each topic, by its global name
    :raises FieldError: if there is no such number; the text names those nearest to it
    """
    columns: List[Column] = []
    for expression in expressions:
        for name in expand_term(expression):
            columns += _columns(name, first_messages)
    return list(dict.fromkeys(columns))


def choose_lines(
    expressions: List[str], first_messages: Mapping[str, Any]
) -> "List[Tuple[Column, ...]]":
    """Return what a list of names stands for: numbers, or each two whose difference is meant.

    :param expressions: as for :func:`choose`, or two of them with ``-`` between
    :param first_messages: a message of each topic, by its global name
    :raises FieldError: as :func:`choose`, and if a difference is not of one number and another
    """
    lines: List[Tuple[Column, ...]] = []
    for expression in expressions:
        parts = [choose([part], first_messages) for part in terms(expression)]
        if len(parts) == 1:
            lines += [(column,) for column in parts[0]]
        elif any(len(columns) != 1 for columns in parts):
            raise FieldError(f"{expression}: one of these names stands for several fields")
        else:
            lines.append((parts[0][0], parts[1][0]))
    return list(dict.fromkeys(lines))


def all_columns(first_messages: Mapping[str, Any]) -> List[Column]:
    """Return all numbers that there are, as far as :func:`.numeric_fields` lists them.

    :param first_messages: a message of each topic, by its global name
    """
    return [
        Column(topic, field.path)
        for topic, message in sorted(first_messages.items())
        for field in numeric_fields(layout_of(type(message)), lengths_in(message))
    ]


def _columns(name: str, first_messages: Mapping[str, Any]) -> List[Column]:
    bare, function, timestamp = parted(name)
    parts = split(bare, first_messages)
    try:
        if parts is None:
            raise FieldError("there is no such topic")
        topic, rest = parts
        message = first_messages[topic]
        layout = layout_of(type(message))
        path_of(timestamp, layout)
        found = [field.path for field in resolve(layout, rest, lengths_in(message), function)]
        if found != [to_path(rest)]:  # of what stands for a part, elements have their names
            found = [with_names(path, partial(_names_at, layout, message)) for path in found]
    except FieldError as error:
        known = [column.name for column in all_columns(first_messages)]
        raise FieldError(f"{name}: {error}; {_hint(bare, known, first_messages)}") from error
    return [Column(topic, path, timestamp, function) for path in found]


def _names_at(layout: Record, message: Any, array: Path) -> List[str]:
    try:
        return list(value_at(message, names_of(layout, array)) or ())
    except FieldError:
        return []


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
