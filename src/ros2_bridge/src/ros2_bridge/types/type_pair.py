# Pure: knows no ROS.
"""Pair of types: counterpart of each field of a ROS 1 type, by name or by mapping rules."""

from typing import Iterator, List, Mapping, NamedTuple, Optional, Sequence

from nodekit.message_definitions import Field, Fields


class FieldRules(NamedTuple):
    """Rules for the fields of a ROS 1 type; paths have dots, and may name a nested message.

    :param other: the ROS 2 type; if a message contains the ROS 1 type, but its counterpart contains
        another ROS 2 type, the rules have no effect there
    :param counterparts: ROS 2 path by ROS 1 path
    :param left_out1: ROS 1 paths without a counterpart, which are zero in ROS 1
    :param left_out2: ROS 2 paths without a counterpart, which have ROS 2's default
    """

    other: str
    counterparts: Mapping[str, str]
    left_out1: Sequence[str] = ()
    left_out2: Sequence[str] = ()


#: Rules by ROS 1 type.
RulesByType = Mapping[str, FieldRules]


class Leaf(NamedTuple):
    """Field that is not a nested message, and its path; arrays of messages are leaves."""

    path: str
    field: Field


class TypePair(NamedTuple):
    """A ROS 1 type and its counterpart.

    :param fields1, first, fields2, second, rules: as of :class:`.FieldMapping`
    """

    fields1: Fields
    first: str
    fields2: Fields
    second: str
    rules: RulesByType

    @property
    def rule(self) -> FieldRules:
        """The rules for the fields of these types; without any, they correspond by name."""
        rule = self.rules.get(self.first)
        return rule if rule and rule.other == self.second else FieldRules(self.second, {})

    def inside(self, path: str, other: str) -> "TypePair":
        """Return the types of a nested message and of its counterpart."""
        first = _type_at(self.fields1, self.first, path)
        second = _type_at(self.fields2, self.second, other)
        return self._replace(first=first, second=second)

    def counterpart(self, path: str) -> Optional[str]:
        """Return the path of a field's counterpart; None if the field is left out.

        The longest path in the rules counts; below it, the rules of the nested message.
        """
        rule, names = self.rule, path.split(".")
        if is_within(path, rule.left_out1):
            return None
        paths = [".".join(names[:count]) for count in range(len(names), 0, -1)]
        place = next((one for one in paths if one in rule.counterparts), names[0])
        other = rule.counterparts.get(place, place.lower())  # ROS 2 has lower case only
        if place == path:
            return other
        inner = self.inside(place, other).counterpart(path[len(place) + 1 :])
        return None if inner is None else f"{other}.{inner}"

    def left_out2(self) -> List[str]:
        """Return the ROS 2 paths that these rules leave out, and those of nested messages."""
        found = list(self.rule.left_out2)
        for path in _nested(self.fields1, self.first):
            other = self.counterpart(path)
            if other is not None:
                rule = self.inside(path, other).rule
                found += [f"{other}.{inner}" for inner in rule.left_out2]
        return found

    def rule_errors(self) -> Iterator[str]:
        """Yield an error for each path that its type does not have, or that has two rules."""
        rule = self.rule
        for path in rule.counterparts:
            if is_within(path, rule.left_out1):
                yield f"{self.first}: {path} is left out, but has a counterpart"
        for fields, datatype, named in (
            (self.fields1, self.first, [*rule.counterparts, *rule.left_out1]),
            (self.fields2, self.second, [*rule.counterparts.values(), *rule.left_out2]),
        ):
            found = leaves(fields, datatype)
            for path in named:
                if not any(is_within(leaf.path, [path]) for leaf in found):
                    yield f"{datatype} has no field {path}"


def leaves(fields: Fields, datatype: str, prefix: str = "") -> List[Leaf]:
    """Return the fields of a type, and those of nested messages in their place."""
    found: List[Leaf] = []
    for field in fields[datatype]:
        if field.base in fields and not field.is_array:
            found += leaves(fields, field.base, f"{prefix}{field.name}.")
        else:
            found.append(Leaf(prefix + field.name, field))
    return found


def _nested(fields: Fields, datatype: str, prefix: str = "") -> Iterator[str]:
    """Yield the path of each nested message, without elements of arrays."""
    for field in fields[datatype]:
        if field.base in fields and not field.is_array:
            yield prefix + field.name
            yield from _nested(fields, field.base, f"{prefix}{field.name}.")


def _type_at(fields: Fields, datatype: str, path: str) -> str:
    """Return the type of a field that is not an array; empty if it is missing."""
    for name in path.split("."):
        found = (f.base for f in fields.get(datatype, ()) if f.name == name and not f.is_array)
        datatype = next(found, "")
    return datatype


def is_within(path: str, places: Sequence[str]) -> bool:
    """Return whether one of these paths is that of a field, or of a message that contains it."""
    return any(path == place or path.startswith(f"{place}.") for place in places)
