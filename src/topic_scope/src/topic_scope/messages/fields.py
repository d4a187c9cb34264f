# Pure: knows no ROS.
"""Names of numeric fields, such as ``/signal/signal_y``, and their resolution.

The notation is rqt_plot's: ``/topic/field/part``; ``/topic/x:y:z`` for several fields of a message;
``/topic/array[3]``; a topic or a part alone denotes all numbers in it. Elements can be selected by
name: ``/joint_states/position[arm]`` is the element at the index of ``arm`` in the
``string[] name`` beside the array, and ``/tf/transforms[child_frame_id=base]/transform`` is in
the first element with this value of the field. A time or a duration is a number too, in s, and a
Boolean is 0 or 1. ``.`` and the name of a function may follow, see
:mod:`topic_scope.messages.field_functions`: ``/topic/field.derivative``; then ``@`` and a
timestamp source, see :mod:`topic_scope.messages.timestamp_source`: ``/topic/field@stamp``.

A topic needs quotes if its name has other characters, or could be a field of another topic:
``"/ORB-SLAM"/pose/x``, ``"/imu/data"/data``. A hyphen before a letter needs no quotes outside
formulas.
"""

import itertools
import re
from functools import lru_cache
from typing import Callable, Collection, Iterator, List, NamedTuple, Optional, Tuple, Union

from topic_scope.messages.message_layout import Array, Layout, MessageLayout, Scalar, Text
from topic_scope.messages.constants import ValueNames
from topic_scope.messages.field_functions import FUNCTIONS, QUATERNION, STATE


class Key(str):
    """Key of an array element in place of its index: ``arm``, ``frame_id=base``."""

    @property
    def field(self) -> str:
        """Field of the elements to compare; empty for the array of names beside the array."""
        return self.partition("=")[0] if "=" in self else ""

    @property
    def value(self) -> str:
        """Its value, or the name."""
        return self.partition("=")[2] if "=" in self else str(self)


#: Names of fields and, after the name of an array, indices or keys of elements.
Path = Tuple[Union[str, int], ...]

#: Returns the length of the array at a path.
Lengths = Callable[[Path], int]

#: Most elements of an array that are listed individually.
LISTED_ELEMENTS = 16
#: Most fields of a topic that are listed or selected together.
LISTED_FIELDS = 200

_FIELD = r"[A-Za-z][A-Za-z0-9_]*(?:/[A-Za-z][A-Za-z0-9_]*)*"
_ELEMENT = rf"\[(?:\d{{1,9}}|[A-Za-z_][A-Za-z0-9_-]*|{_FIELD}=[^][\"\n]{{1,100}})\]"
#: Brackets with any text in them.
_BRACKETS = re.compile(r"\[[^]]*\]")
_NAME = rf"[A-Za-z][A-Za-z0-9_]*(?:{_ELEMENT})*"
#: A topic in quotes, and a name that may have hyphens.
_TOPIC = r'"/[^"\n]{1,200}"'
_HYPHENS = rf"[A-Za-z][A-Za-z0-9_]*(?:-[A-Za-z][A-Za-z0-9_]*)*(?:{_ELEMENT})*"
_END = rf"(?:@{_NAME}(?:/{_NAME})*)?"
_EXPRESSION = re.compile(
    rf"(?:{_TOPIC}(?:(?:/{_NAME})+(?::{_NAME})*)?"
    rf"|(?:/|~?/?){_HYPHENS}(?:/{_HYPHENS})*(?::{_NAME})*)(?:\.([a-z]+))?{_END}\Z"
)
#: A field that other text may follow: a single field, from its slash or quote on.
FIELD = re.compile(rf"(?:{_TOPIC}|/{_NAME})(?:/{_NAME})*(?:\.[a-z]+)?{_END}")
_QUOTED = re.compile(_TOPIC)
_PART = re.compile(rf"([A-Za-z][A-Za-z0-9_]*)((?:{_ELEMENT})*)\Z")
#: Field with the names of elements, beside their arrays.
_NAMES = "name"
_LONGEST = 300


class FieldError(ValueError):
    """Invalid name of a field, or a field that a message does not have."""


class NumericField(NamedTuple):
    """Number in the messages of a topic.

    :param path: its path in a message
    :param datatype: its type in the definition, e.g. ``float32``
    """

    path: Path
    datatype: str


def one_element(_path: Path) -> int:
    """Return 1, the assumed length of each array."""
    return 1


def expand(expression: str) -> List[str]:
    """Return the field names that an argument denotes.

    :param expression: e.g. ``/pose/x:y``, which denotes ``/pose/x`` and ``/pose/y``
    :returns: global names, one for each part between colons
    :raises FieldError: if it is not a valid name
    """
    match = _EXPRESSION.match(expression) if len(expression) <= _LONGEST else None
    if not match:
        raise FieldError(
            f"{expression[:_LONGEST]!r} is not the name of a field, such as /topic/field"
        )
    if match.group(1) and match.group(1) not in FUNCTIONS:
        raise FieldError(f"unknown function .{match.group(1)}; known are .{', .'.join(FUNCTIONS)}")
    topic = _quoted(expression)
    rest = expression[len(topic) :]
    place = re.search("[.@]|$", _bare(rest)).start()  # type: ignore[union-attr]
    names, end = rest[:place], rest[place:]
    first, *others = _split(names, ":")
    first = topic + first if topic else "/" + first.lstrip("/")
    parent = first[: _bare(first).rindex("/")]
    return [first + end] + [f"{parent}/{other}{end}" for other in others]


@lru_cache(maxsize=1024)
def parted(name: str) -> Tuple[str, str, str]:
    """Split off the function and the timestamp source of a name.

    :param name: one that :func:`expand` returned
    :returns: the name without them, and both, each empty if not given
    """
    topic = _quoted(name)
    rest = name[len(topic) :]
    at = (_bare(rest) + "@").index("@")
    names, timestamp = rest[:at], rest[at + 1 :]
    point = (_bare(names) + ".").index(".")
    return topic + names[:point], names[point + 1 :], timestamp


def ending(function: str, timestamp: str) -> str:
    """Return the suffix of a name with the given parts; reverses :func:`parted`."""
    return (function and f".{function}") + (timestamp and f"@{timestamp}")


def split(name: str, topics: Collection[str]) -> Optional[Tuple[str, str]]:
    """Split a name into a topic and a field of its messages.

    :param name: one that :func:`expand` returned, without the timestamp source
    :param topics: names of the existing topics
    :returns: the longest topic that the name starts with, and the rest, empty for the whole
        message; None if there is no such topic
    """
    quoted = _quoted(name)
    if quoted:
        return (quoted[1:-1], name[len(quoted) + 1 :]) if quoted[1:-1] in topics else None
    topic = name
    while topic:
        if topic in topics:
            return topic, name[len(topic) + 1 :]
        topic = topic[: max(_bare(topic).rfind("/"), 0)]
    return None


def name_of(topic: str, path: Path, topics: Collection[str]) -> str:
    """Return the name of a field, with its topic in quotes if necessary.

    :param topic: global name of the topic
    :param path: path of the field in a message; empty for the whole message
    :param topics: names of the existing topics
    """
    rest = to_text(path)
    plain = f"{topic}/{rest}" if rest else topic
    if FIELD.fullmatch(plain) and split(plain, topics) == (topic, rest):
        return plain
    return f'"{topic}"/{rest}' if rest else f'"{topic}"'


def _bare(text: str) -> str:
    """Return a text of the same length, with the contents of its brackets masked."""
    return _BRACKETS.sub(lambda match: "_" * len(match.group()), text)


def _split(text: str, mark: str) -> List[str]:
    """Split a text at a separator outside brackets."""
    places = [-1, *(match.start() for match in re.finditer(mark, _bare(text))), len(text)]
    return [text[start + 1 : end] for start, end in zip(places, places[1:])]


def _quoted(name: str) -> str:
    """Return the quoted topic at the start of a name, with its quotes; empty without one."""
    match = _QUOTED.match(name)
    return match.group() if match else ""


@lru_cache(maxsize=1024)
def to_path(text: str) -> Path:
    """Return the path of a text such as ``pose/x`` or ``data[3]``.

    :raises FieldError: if it is invalid
    """
    path: List[Union[str, int]] = []
    for part in _split(text, "/") if text else []:
        match = _PART.match(part)
        if not match:
            raise FieldError(f"{part!r} is not the name of a field")
        path.append(match.group(1))
        elements = [one[1:-1] for one in _BRACKETS.findall(match.group(2))]
        path += [int(one) if one.isdigit() else Key(one) for one in elements]
    return tuple(path)


def to_text(path: Path) -> str:
    """Return a path as text."""
    parts = [f"[{part}]" if isinstance(part, (int, Key)) else "/" + part for part in path]
    return "".join(parts).lstrip("/")


def resolve(
    layout: MessageLayout, text: str, lengths: Lengths = one_element, function: str = ""
) -> List[NumericField]:
    """Return the numeric fields that a text denotes in a message.

    :param layout: layout of the messages
    :param text: as :func:`split` returned it; empty for the whole message
    :param lengths: returns the length of an array of variable length
    :param function: name of the function applied to each; for yaw, quaternions are returned
    :raises FieldError: if the type has no such field
    """
    path = to_path(text)
    node = leaf_at(layout, path)
    if function == STATE:
        kind, fields = "text, and no number with named values,", _states(layout, path, lengths)
    elif function == "yaw":
        kind, fields = "quaternion", _found(node, path, lengths, _is_quaternion)
    else:
        kind, fields = "number", _found(node, path, lengths, _is_number)
    found = list(itertools.islice(fields, LISTED_FIELDS))
    if not found:
        raise FieldError(f"there is no {kind} in {to_text(path) or layout.datatype}")
    return found


def quaternions(layout: MessageLayout, lengths: Lengths = one_element) -> List[NumericField]:
    """List the quaternions of a message; as :func:`numeric_fields`."""
    return list(itertools.islice(_found(layout, (), lengths, _is_quaternion), LISTED_FIELDS))


def states(layout: MessageLayout, lengths: Lengths = one_element) -> List[NumericField]:
    """List the texts and the numbers with named values of a message; as :func:`numeric_fields`.

    Arrays of texts, and the frame of a header, are not listed; they can be named.
    """
    return list(itertools.islice(_states(layout, (), lengths), LISTED_FIELDS))


def is_text(layout: MessageLayout, text: str) -> bool:
    """Return whether a text such as ``status[0]/name`` denotes a string in a message."""
    try:
        return isinstance(leaf_at(layout, to_path(text)), Text)
    except FieldError:
        return False


def value_names_at(layout: MessageLayout, path: Path) -> ValueNames:
    """Return the value names of the field at a path; empty without any."""
    parent = leaf_at(layout, path[:-1])
    return parent.value_names.get(str(path[-1]), {}) if isinstance(parent, MessageLayout) else {}


def leaf_at(layout: MessageLayout, path: Path) -> Layout:
    """Return the layout at a path in a message.

    :param layout: layout of the messages
    :param path: the path
    :raises FieldError: if the message does not have the path
    """
    node: Layout = layout
    for position, part in enumerate(path):
        if isinstance(part, Key) and not part.field:
            names_of(layout, path[:position])
        elif isinstance(part, Key) and isinstance(node, Array):
            label_of(node.element, part.field)
        node = _step(node, part, to_text(path[:position]) or layout.datatype)
    return node


def names_of(layout: MessageLayout, path: Path) -> Path:
    """Return the path of the names of an array's elements.

    :param layout: layout of the messages
    :param path: path of the array
    :raises FieldError: if its elements do not have names
    """
    place = path[:-1] + (_NAMES,)
    try:
        names = leaf_at(layout, place)
    except FieldError:
        names = layout
    if isinstance(names, Array) and names.length is None and isinstance(names.element, Text):
        return place
    raise FieldError(f"the elements of {to_text(path)} have no names, only numbers")


def label_of(element: Layout, field: str) -> Layout:
    """Return the layout of the field that identifies elements of an array.

    :param element: layout of the elements
    :param field: name of the field
    :raises FieldError: if the field does not exist, or is neither a text nor an integer
    """
    if not isinstance(element, MessageLayout):
        raise FieldError(f"{element.datatype} has no {field}")
    leaf = leaf_at(element, to_path(field))
    is_whole = isinstance(leaf, Scalar) and leaf.format in "bBhHiIqQ"
    if not is_whole and not isinstance(leaf, Text):
        raise FieldError(f"{field} is neither a text nor a whole number")
    return leaf


def numeric_fields(layout: MessageLayout, lengths: Lengths = one_element) -> List[NumericField]:
    """List the numeric fields of a message; only the first of long arrays and messages.

    :param layout: layout of the messages
    :param lengths: as for :func:`resolve`
    """
    return list(itertools.islice(_found(layout, (), lengths, _is_number), LISTED_FIELDS))


def _step(node: Layout, part: Union[str, int], place: str) -> Layout:
    if isinstance(part, (int, Key)):
        if not isinstance(node, Array):
            raise FieldError(f"{place} is not an array")
        if isinstance(part, int) and node.length is not None and part >= node.length:
            raise FieldError(f"{place} has only {node.length} elements")
        return node.element
    fields = dict(node.fields) if isinstance(node, MessageLayout) else {}
    if part not in fields:
        raise FieldError(f"there is no {part} in {place}")
    return fields[part]


def _is_number(node: Layout) -> bool:
    return isinstance(node, Scalar)


def _is_quaternion(node: Layout) -> bool:
    if not isinstance(node, MessageLayout) or tuple(name for name, _ in node.fields) != QUATERNION:
        return False
    return all(isinstance(field, Scalar) for _, field in node.fields)


def _found(
    node: Layout, path: Path, lengths: Lengths, is_wanted: Callable[[Layout], bool]
) -> Iterator[NumericField]:
    if is_wanted(node):
        yield NumericField(path, node.datatype)
    elif isinstance(node, MessageLayout) and node.numeric:
        for name, field in node.fields:
            yield from _found(field, path + (name,), lengths, is_wanted)
    elif isinstance(node, Array) and node.numeric:
        count = lengths(path) if node.length is None else node.length
        for index in range(min(count, LISTED_ELEMENTS)):
            yield from _found(node.element, path + (index,), lengths, is_wanted)


def _states(layout: MessageLayout, path: Path, lengths: Lengths) -> Iterator[NumericField]:
    """Return the states at and below a path in a message."""
    node = leaf_at(layout, path)
    if isinstance(node, Text) or (path and value_names_at(layout, path)):
        yield NumericField(path, node.datatype)
    elif isinstance(node, MessageLayout):
        for name, field in node.fields:
            if node.datatype != "std_msgs/Header" and not isinstance(field, Scalar):
                yield from _states(layout, path + (name,), lengths)
            elif name in node.value_names:
                yield NumericField(path + (name,), field.datatype)
    elif isinstance(node, Array) and isinstance(node.element, MessageLayout):
        count = lengths(path) if node.length is None else node.length
        for index in range(min(count, LISTED_ELEMENTS)):
            yield from _states(layout, path + (index,), lengths)
