# Pure: knows no ROS.
"""Lengths of arrays in serialized messages, and their elements' names, such as joint names."""

import contextlib
import itertools
import re
import struct
from functools import partial
from typing import Callable, Dict, List, Optional, Sequence, Tuple, Union

from topic_scope.messages.decoding import COUNT, ElementMissing, follow, labels, steps_to, texts
from topic_scope.messages.message_layout import Array, MessageLayout, Text
from topic_scope.messages.fields import (
    Key,
    FieldError,
    Lengths,
    Path,
    leaf_at,
    names_of,
    to_text,
)

#: Most arrays of a topic whose lengths are stored.
_ARRAYS = 1000
#: Most sets of element names of a topic, and how long each is valid [s].
_KINDS, KEPT_S = 16, 30.0
#: Fields that identify elements of arrays, e.g. of transforms and of diagnostics.
LABELS = ("child_frame_id", "name")
#: A name that is allowed in brackets.
_KEY = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*\Z")
_VALUE = re.compile(r'[^]["\n]{1,100}\Z')
#: Most names in an error text.
_SHOWN = 10


def lengths_in(layout: MessageLayout, data: bytes) -> Lengths:
    """Return the function that returns the lengths of arrays of a serialized message.

    :param layout: its layout
    :param data: the message
    """

    def length(path: Path) -> int:
        try:
            return int(COUNT.unpack_from(data, follow(steps_to(layout, path)[0], data))[0])
        except (ElementMissing, struct.error):
            return 0

    return length


def names_in(layout: MessageLayout, data: bytes, path: Path, field: str = "") -> List[str]:
    """Return the names of an array's elements in a serialized message.

    :param layout: its layout
    :param data: the message
    :param path: path of the array
    :param field: field of the elements with their names; empty for the array of names beside it
    :returns: the names; empty if the elements have no names
    """
    try:
        if field:
            steps, array = steps_to(layout, path)
            read = labels(array, field) if isinstance(array, Array) else None
            return [label for label, _ in read(data, follow(steps, data))] if read else []
        steps, _ = steps_to(layout, names_of(layout, path))
        return [text.decode(errors="replace") for text in texts(data, follow(steps, data))]
    except (FieldError, ElementMissing, struct.error):
        return []


def keys_in(layout: MessageLayout, data: bytes, path: Path) -> List[str]:
    """Return the keys of the elements of an array, as written in brackets.

    :param layout: layout of the message
    :param data: the message
    :param path: path of the array
    :returns: names or values of a field; an empty string for a key that cannot be written
    """
    names = names_in(layout, data, path)
    if names:
        return [name if _KEY.match(name) else "" for name in names]
    for field in LABELS:
        values = names_in(layout, data, path, field)
        if values:
            return [f"{field}={value}" if _VALUE.match(value) else "" for value in values]
    return []


def with_names(path: Path, names_at: Callable[[Path], Sequence[str]], typed: int = 0) -> Path:
    """Return a path with indices replaced by names of elements, where the elements have names.

    :param path: with indices
    :param names_at: returns the keys of the elements of an array; see :func:`keys_in`
    :param typed: number of leading parts of the path that are not changed
    """
    found: Path = ()
    for part in path:
        if isinstance(part, int) and len(found) >= typed:
            names = names_at(found)
            name = names[part] if part < len(names) else ""
            # Names may be duplicates.
            if name and names.count(name) == 1:
                part = Key(name)
        found += (part,)
    return found


def has_names(layout: MessageLayout) -> bool:
    """Return whether any array in a message has named elements."""
    parts = [name for name, node in layout.fields if isinstance(node, Array) and node.numeric]
    try:
        return bool(parts) and bool(names_of(layout, (parts[0],)))
    except FieldError:
        return False


def check_elements(layout: MessageLayout, path: Path, data: bytes) -> None:
    """Check that the array elements of a path exist in a message.

    :param layout: layout of the messages
    :param path: the path
    :param data: a serialized message
    :raises FieldError: if an array is too short, or none of its elements has the name
    """
    place, part = first_missing(layout, path, data)
    if isinstance(part, Key):
        names = ", ".join(names_in(layout, data, place, part.field)[:_SHOWN])
        raise FieldError(f"{missing_text(place, part)} now, but {names or '-'}")
    if part is not None:
        count = lengths_in(layout, data)(place)
        raise FieldError(f"{to_text(place)} has {count} elements now")


def missing_text(place: Path, key: Key) -> str:
    """Return the error text for an array without an element of a name or value."""
    if key.field:
        return f"no element of {to_text(place)} has the {key.field} {key.value}"
    return f"no element of {to_text(place)} is named {key}"


def first_missing(
    layout: MessageLayout, path: Path, data: bytes
) -> Tuple[Path, Union[str, int, None]]:
    """Return the first array of a path that lacks an element, and the missing element.

    :param layout: layout of the messages
    :param path: the path
    :param data: a serialized message
    :returns: the path of the array, and the name or index; None for the latter if none is missing
    :raises FieldError: if the layout does not have the path
    """
    lengths = lengths_in(layout, data)
    for position, part in enumerate(path):
        place = path[:position]
        node = leaf_at(layout, place)
        if isinstance(part, Key) and part.value not in names_in(layout, data, place, part.field):
            return place, part
        if isinstance(part, int) and isinstance(node, Array) and node.length is None:
            if part >= lengths(place):
                return place, part
    return path, None


def _named_arrays(layout: MessageLayout) -> List[Tuple[Path, str]]:
    """Return the arrays with named elements: the path, and the field, as for :func:`names_in`."""
    found: List[Tuple[Path, str]] = []
    with contextlib.suppress(FieldError):
        names_of(layout, ("",))
        found.append((("",), ""))
    for name, node in layout.fields:
        if isinstance(node, Array) and isinstance(node.element, MessageLayout):
            fields = dict(node.element.fields)
            found += [((name,), one) for one in LABELS if isinstance(fields.get(one), Text)][:1]
    return found


class Arrays:
    """Arrays of a topic, with their largest lengths, so that lists of fields do not change."""

    def __init__(self) -> None:
        self._known: Dict[Path, int] = {}
        self._named: Dict[Path, List[Path]] = {}
        self._layout: Optional[MessageLayout] = None
        #: Arrays whose names distinguish messages about different elements.
        self._named_arrays: List[Tuple[Path, str]] = []
        #: Time of receipt [s] and latest message by its names; publishers may differ in names.
        self._messages: Dict[Tuple[str, ...], Tuple[float, bytes]] = {}

    def add_message(self, layout: MessageLayout, message: bytes, time: float = 0.0) -> None:
        """Add the latest message.

        :param layout: its layout
        :param message: the message
        :param time: time of receipt [s]
        """
        if layout is not self._layout:
            self._layout, self._messages = layout, {}
            self._named_arrays = _named_arrays(layout)
        named = (names_in(layout, message, *array) for array in self._named_arrays)
        known = {**self._messages, tuple(itertools.chain(*named)): (time, message)}
        recent = sorted(known.values(), reverse=True)[:_KINDS]
        self._messages = {
            names: one for names, one in known.items() if one in recent and one[0] > time - KEPT_S
        }

    def __call__(self, path: Path) -> int:
        """Return the largest length of an array so far."""
        latest = 1
        if self._layout is not None:
            try:
                latest = max(lengths_in(self._layout, one)(path) for one in self._latest())
            except FieldError:  # the type of the topic has changed
                pass
        longest = max(latest, self._known.get(path, 0))
        if path in self._known or len(self._known) < _ARRAYS:
            self._known[path] = longest
        return longest

    def _latest(self) -> List[bytes]:
        """Return the stored messages, the latest first."""
        return [message for _, message in sorted(self._messages.values(), reverse=True)]

    def check(self, layout: MessageLayout, path: Path) -> None:
        """Check that one of the latest messages contains a path.

        :param layout: current layout of the messages
        :raises FieldError: if none does
        """
        errors = []
        for message in self._latest():
            try:
                return check_elements(layout, path, message)
            except FieldError as error:
                errors.append(error)
        if errors:
            raise errors[0]

    def named(self, path: Path, typed: int = 0) -> List[Path]:
        """Return a path with indices replaced by names of elements, where the elements have names.

        :param path: with indices
        :param typed: number of leading parts of the path that are not changed
        :returns: several paths if messages of the topic differ in names
        """
        layout = self._layout
        if layout is None:
            return [path]
        messages = [message for _, message in self._messages.values()]
        found = [with_names(path, partial(keys_in, layout, one), typed) for one in messages]
        return list(dict.fromkeys(one for one in found if one != path)) or [path]

    def remembered(self, path: Path, typed: int = 0) -> List[Path]:
        """Return :meth:`named` with all its earlier results, so that lists do not change."""
        found = self.named(path, typed)
        if found != [path] and (path in self._named or len(self._named) < _ARRAYS):
            known = dict.fromkeys([*self._named.get(path, []), *found])
            self._named[path] = list(known)[:_KINDS]
        return self._named.get(path, found)
