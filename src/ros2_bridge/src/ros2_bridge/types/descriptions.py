# Pure: knows no ROS.
"""Comparison of two descriptions of a ROS 2 type, field by field, in the order of their bytes.

A subscriber and a publisher in DDS match by the name of the type alone.
"""

from typing import List, Mapping, NamedTuple, Sequence

#: Most fields of a definition in a message to the user.
_MOST = 12


class Field(NamedTuple):
    """A field of a type.

    :param name: its name, after that of the field that holds it and a dot
    :param kind: its type: of a message, the name; else as ROS 2's descriptions name it
    """

    name: str
    kind: str

    def __str__(self) -> str:
        return f"{self.kind} {self.name}"


#: Fields of each type that a description has, by its name ``package/msg/Name``.
Types = Mapping[str, Sequence[Field]]

#: How ROS 2's names of kinds end, and what stands for it after the name of an element.
_ENDINGS = {
    "_unbounded_sequence": "[]",
    "_bounded_sequence": "[<={}]",
    "_array": "[{}]",
}


def kind_of(name: str, nested: str, capacity: int) -> str:
    """Return the type of a field, such as ``double[3]``.

    :param name: ROS 2's name of its kind, such as ``double_array``
    :param nested: name of the message that it holds, if it does
    :param capacity: length of an array, or most elements of a sequence
    """
    brackets = ""
    for ending, text in _ENDINGS.items():
        if name.endswith(ending):
            name, brackets = name[: -len(ending)], text.format(capacity)
            break
    return (nested or name) + brackets


def flatten(types: Types, name: str, prefix: str = "") -> List[Field]:
    """Return the fields of a type in the order of their bytes, those of nested messages too.

    :param types: the types
    :param name: name of the type
    :param prefix: put before the names
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
    """Return whether the bytes of both definitions mean the same, apart from names.

    :param ours: fields, flattened
    :param theirs: fields, flattened
    """
    return [field.kind for field in ours] == [field.kind for field in theirs]


def is_renamed_in_order(ours: Sequence[Field], theirs: Sequence[Field]) -> bool:
    """Return whether the layout is the same and no name of one stands elsewhere in the other.

    Where two fields of one type have changed places, each value would be the other's.

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
