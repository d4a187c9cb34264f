"""Which numbers of a bag's messages were asked for."""

import difflib
from typing import Any, List, Mapping, NamedTuple

from topic_scope.definitions import layout_of
from topic_scope.fields import (
    FieldError,
    Path,
    ending,
    expand,
    numeric_fields,
    parted,
    resolve,
    split,
    to_text,
)
from topic_scope.time_base import path_of
from topic_scope.values import lengths_in


class Column(NamedTuple):
    """A number that the messages of a topic have.

    :param topic: global name of the topic
    :param path: where the number stands in a message
    :param base: name of the time to plot it over; see :func:`.time_base.path_of`
    :param function: name of what is computed of it; see :mod:`.derived`
    """

    topic: str
    path: Path
    base: str = ""
    function: str = ""

    @property
    def name(self) -> str:
        """The name of the field, e.g. ``/signal/signal_y``."""
        field = f"{self.topic}/{to_text(self.path)}" if self.path else self.topic
        return field + ending(self.function, self.base)


def choose(expressions: List[str], first_messages: Mapping[str, Any]) -> List[Column]:
    """Return what a list of names stands for, each number once.

    :param expressions: names in the notation of :mod:`topic_scope.fields`
    :param first_messages: a message of each topic, by its global name
    :raises FieldError: if there is no such number; the text names those nearest to it
    """
    columns: List[Column] = []
    for expression in expressions:
        for name in expand(expression):
            columns += _columns(name, first_messages)
    return list(dict.fromkeys(columns))


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
    bare, function, base = parted(name)
    parts = split(bare, first_messages)
    try:
        if parts is None:
            raise FieldError("there is no such topic")
        topic, rest = parts
        message = first_messages[topic]
        layout = layout_of(type(message))
        path_of(base, layout)
        found = resolve(layout, rest, lengths_in(message), function)
    except FieldError as error:
        known = [column.name for column in all_columns(first_messages)]
        near = difflib.get_close_matches(name, known, n=3, cutoff=0.5) or known[:3]
        hint = f"nearest to it: {', '.join(near)}" if near else "there are no numbers at all"
        raise FieldError(f"{name}: {error}; {hint}") from error
    return [Column(topic, field.path, base, function) for field in found]
