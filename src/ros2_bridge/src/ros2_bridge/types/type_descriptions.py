# Pure: knows no ROS.
"""Comparison of two ROS 2 type descriptions (REP 2011), field by field, in serialization order.

In DDS, a subscriber and a publisher match by the name of the type alone.
"""

from typing import List, Mapping, NamedTuple, Sequence

#: Most fields of a definition shown in a message.
_MOST = 12


class Field(NamedTuple):
    """A field of a type.

    :param name: its name, with the name of the containing field and a dot before it
    :param kind: its type: for a message its name, else ROS 2's type name
    """

    name: str
    kind: str

    def __str__(self) -> str:
        return f"{self.kind} {self.name}"


#: Fields of each type in a description, by its name ``package/msg/Name``.
Types = Mapping[str, Sequence[Field]]

#: Suffixes of ROS 2's type names, and what replaces them after the element type.
_ENDINGS = {
    "_unbounded_sequence": "[]",
    "_bounded_sequence": "[<={}]",
    "_array": "[{}]",
}


def kind_of(name: str, nested: str, capacity: int) -> str:
    """Return the type of a field, such as ``double[3]``.

    :param name: ROS 2's type name, such as ``double_array``
    :param nested: name of the nested message, if any
    :param capacity: length of an array, or limit of a sequence
    """
    brackets = ""
    for ending, text in _ENDINGS.items():
        if name.endswith(ending):
            name, brackets = name[: -len(ending)], text.format(capacity)
            break
    return (nested or name) + brackets


def flatten(types: Types, name: str, prefix: str = "") -> List[Field]:
    """Return the fields of a type in serialization order, including nested fields.

    :param types: the types
    :param name: name of the type
    :param prefix: prefix of the names
    """
    fields: List[Field] = []
    for field in types[name]:
        nested, _, array = field.kind.partition("[")
        if nested in types:
            if array:
                fields.append(Field(prefix + field.name, f"[{array}"))
            fields += flatten(types, nested, f"{prefix}{field.name}.")
        else:
            fields.append(Field(prefix + field.name, field.kind))
    return fields


def has_same_layout(ours: Sequence[Field], theirs: Sequence[Field]) -> bool:
    """Return whether both definitions have the same layout, ignoring names.

    :param ours: fields, flattened
    :param theirs: fields, flattened
    """
    return [field.kind for field in ours] == [field.kind for field in theirs]


def is_renamed_in_order(ours: Sequence[Field], theirs: Sequence[Field]) -> bool:
    """Return whether the layout is the same, and no name has moved to another position.

    If two fields of the same type were swapped, their values would be, too.

    :param ours: fields, flattened
    :param theirs: fields, flattened
    """
    places = {field.name: place for place, field in enumerate(ours)}
    return has_same_layout(ours, theirs) and all(
        places.get(field.name, place) == place for place, field in enumerate(theirs)
    )


def as_text(fields: Sequence[Field]) -> str:
    """Return a definition on one line."""
    more = f", and {len(fields) - _MOST} more" if len(fields) > _MOST else ""
    return ", ".join(map(str, fields[:_MOST])) + more
