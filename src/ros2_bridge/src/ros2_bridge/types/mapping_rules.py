# Pure: knows no ROS.
"""Mapping rules of the user: which ROS 2 type a ROS 1 type becomes, and with which fields."""

import functools
import re
from typing import Any, Dict, Iterable, List, Mapping, NamedTuple, Sequence, Tuple

from nodekit import ParameterError
from ros2_bridge.types.name_pairs import pair_names
from ros2_bridge.types.ros2_interfaces import twin_type
from ros2_bridge.types.type_pair import FieldRules

#: Parts of each kind of interface, as ROS 1 ends the names of their types.
PARTS: Mapping[str, Sequence[str]] = {
    "msg": ("",),
    "srv": ("Request", "Response"),
    "action": ("Goal", "Result", "Feedback"),
}
_PACKAGE = re.compile(r"[a-z][a-z0-9_]*\Z")
_ROS1 = re.compile(r"[A-Za-z]\w*/[A-Za-z]\w*\Z", re.ASCII)
_ROS2 = re.compile(r"([a-z][a-z0-9_]*)/(msg|srv|action)/([A-Z][A-Za-z0-9]*)\Z")
_KEYS = {"ros1", "ros2", "fields", "left_out"}


class MappingRuleError(ParameterError):
    """Error of a malformed rule, or of one that does not fit its types.

    :param why: the rule's types and the reason
    """

    def __init__(self, why: str) -> None:
        super().__init__("mappings", None, why)

    def __str__(self) -> str:
        return f"parameter mappings: {self.allowed}"


class TypeRule(NamedTuple):
    """Rule for a type.

    :param kind: ``msg``, ``srv`` or ``action``
    :param ros1, ros2: its names, both as ``package/Name``
    :param fields: rules for the fields, by ROS 1 name of the type or of its parts
    """

    kind: str
    ros1: str
    ros2: str
    fields: Mapping[str, FieldRules]


class MappingRules:
    """Rules by type and by package.

    :param rules: list of mappings: ``ros1`` and ``ros2`` (two packages, or two types, the second
        as ``package/msg/Name``), and of types also ``fields``, ROS 2 path by ROS 1 path, and
        ``left_out``, with lists of paths ``ros1`` and ``ros2``. Paths in services and actions begin
        with the part, such as ``goal``
    :param builtin: further rules, for types that the others do not name
    :raises MappingRuleError: if one is malformed, or two rules name the same type
    """

    def __init__(self, rules: Any, builtin: Any = ()) -> None:
        #: by kind and ROS 1 name: a message and a service may have the same name
        self._types: Dict[Tuple[str, str], TypeRule] = {}
        #: ROS 2 package by ROS 1 package
        self.packages: Dict[str, str] = {}
        for rule in _as_list(rules):
            self._add(rule)
        #: the user's rules for types, without those that are built in
        self.own = list(self._types.values())
        for rule in _as_list(builtin):
            one = _type_rule(rule)
            if not self._is_named(one) and one.ros1.partition("/")[0] not in self.packages:
                self._types[one.kind, one.ros1] = one
        self._back = {(rule.kind, rule.ros2): rule.ros1 for rule in self._types.values()}
        self._packages_back = {its: ours for ours, its in self.packages.items()}
        #: ROS 2 name of each type of a renamed package, by kind and ROS 1 name, and the reverse.
        self._names: Dict[Tuple[str, str], str] = {}
        self._names_back: Dict[Tuple[str, str], str] = {}
        #: Reasons why types of renamed packages have no counterpart, by kind and ROS 1 name.
        self.unclear: Dict[Tuple[str, str], str] = {}

    def _add(self, rule: Any) -> None:
        names = _names(rule)
        if "/" in names[0]:
            one = _type_rule(rule)
            if self._is_named(one):
                raise MappingRuleError(f"{one.ros1} or {one.ros2} is in several rules")
            self._types[one.kind, one.ros1] = one
            return
        for name in names:
            if not _PACKAGE.match(name):
                raise MappingRuleError(f"{name!r} is not the name of a package")
        if set(rule) - {"ros1", "ros2"}:
            raise MappingRuleError(f"fields of the package {names[0]}: allowed only for types")
        if names[0] in self.packages or names[1] in self.packages.values():
            raise MappingRuleError(f"{names[0]} or {names[1]} is in several rules")
        self.packages[names[0]] = names[1]

    def pair_types(self, kind: str, package: str, ros1: Iterable[str], ros2: Iterable[str]) -> None:
        """Pair the types of a renamed package, except those with a rule of their own.

        :param package: name in ROS 1
        :param ros1, ros2: names of its types of this kind, without the package
        """
        other = self.packages[package]
        pairs = pair_names(
            [name for name in ros1 if (kind, f"{package}/{name}") not in self._types],
            [name for name in ros2 if (kind, f"{other}/{name}") not in self._back],
        )
        for name, its in pairs.found.items():
            self._names[kind, f"{package}/{name}"] = f"{other}/{its}"
            self._names_back[kind, f"{other}/{its}"] = f"{package}/{name}"
        for name, names in pairs.unclear.items():
            self.unclear[kind, f"{package}/{name}"] = (
                f"{package}/{name}: the names {', '.join(names)} differ only in case and"
                f" underscores; name its counterpart in {other} in a mapping rule for the type"
            )

    def _is_named(self, rule: TypeRule) -> bool:
        """Return whether another rule names a type of this one."""
        theirs = {(one.kind, one.ros2) for one in self._types.values()}
        return (rule.kind, rule.ros1) in self._types or (rule.kind, rule.ros2) in theirs

    def ros2_name(self, kind: str, name: str) -> str:
        """Return the ROS 2 name, ``package/Name``, of a ROS 1 type; empty without a rule."""
        if (kind, name) in self._types:
            return self._types[kind, name].ros2
        package, _, base = name.partition("/")
        other = self.packages.get(package)
        default = twin_type(f"{other}/{base}") if other is not None else ""
        return self._names.get((kind, name), default)

    def ros1_name(self, kind: str, name: str) -> str:
        """Return the ROS 1 name of a ROS 2 type, ``package/Name``; empty without a rule."""
        if (kind, name) in self._back:
            return self._back[kind, name]
        package, _, base = name.partition("/")
        ours = self._packages_back.get(package)
        return self._names_back.get((kind, name), f"{ours}/{base}" if ours is not None else "")

    def is_taken(self, kind: str, ros1: str, ros2: str) -> bool:
        """Return whether a rule gives a ROS 1 type another counterpart than this ROS 2 type."""
        return self.ros2_name(kind, ros1) not in ("", ros2)

    def assigns_fields(self, names: Iterable[str]) -> bool:
        """Return whether the user has rules for the fields of one of these ROS 1 types."""
        own = {part: one for rule in self.own for part, one in rule.fields.items()}
        found = (own[name] for name in names if name in own)
        return any(one.counterparts or one.left_out1 or one.left_out2 for one in found)

    @property
    def fields(self) -> Dict[str, FieldRules]:
        """The rules for fields, by ROS 1 type."""
        return {name: one for rule in self._types.values() for name, one in rule.fields.items()}


def is_type_name(name: str) -> bool:
    """Return whether ROS 2 allows a name, without the package, for a type."""
    return _ROS2.match(f"package/msg/{name}") is not None


def _as_list(rules: Any) -> List[Any]:
    if not isinstance(rules, (list, tuple)):
        raise MappingRuleError(f"{rules!r:.60} is not a list of rules")
    return list(rules)


def _names(rule: Any) -> Tuple[str, str]:
    if not isinstance(rule, dict) or not all(
        isinstance(rule.get(k), str) for k in ("ros1", "ros2")
    ):
        raise MappingRuleError(f"{rule!r:.60} is not a rule with texts ros1 and ros2")
    unknown = set(rule) - _KEYS
    if unknown:
        allowed = ", ".join(sorted(_KEYS))
        raise MappingRuleError(f"{rule['ros1']}: {min(map(str, unknown))} is not one of {allowed}")
    return rule["ros1"], rule["ros2"]


def _type_rule(rule: Any) -> TypeRule:
    ros1, ros2 = _names(rule)
    match = _ROS2.match(ros2)
    if not _ROS1.match(ros1) or match is None:
        raise MappingRuleError(
            f"{ros1} to {ros2}: types are named as in package/Name (ROS 1) and"
            " package/msg/Name, package/srv/Name or package/action/Name (ROS 2)"
        )
    package, kind, base = match.groups()
    counterparts = rule.get("fields") or {}
    left_out = rule.get("left_out") or {}
    if not isinstance(counterparts, dict) or not _are_texts(
        [*counterparts, *counterparts.values()]
    ):
        raise MappingRuleError(f"{ros1}: fields: {counterparts!r:.60} is not a mapping of texts")
    if not isinstance(left_out, dict) or set(left_out) - {"ros1", "ros2"}:
        raise MappingRuleError(f"{ros1}: left_out: {left_out!r:.60} has other keys than ros1, ros2")
    lists = [left_out.get("ros1") or [], left_out.get("ros2") or []]
    if not all(isinstance(one, list) and _are_texts(one) for one in lists):
        raise MappingRuleError(f"{ros1}: left_out: {left_out!r:.60} has no lists of texts")
    found = {}
    for part in PARTS[kind]:
        of = functools.partial(_is_of, ros1, kind, part)
        found[ros1 + part] = FieldRules(
            f"{package}/{base}_{part}" if part else f"{package}/{base}",
            {_inner(a, part): _inner(b, part) for a, b in counterparts.items() if of(a) and of(b)},
            [_inner(path, part) for path in lists[0] if of(path)],
            [_inner(path, part) for path in lists[1] if of(path)],
        )
    crossing = [a for a, b in counterparts.items() if kind != "msg" and _part(a) != _part(b)]
    if crossing:
        raise MappingRuleError(f"{ros1}: {crossing[0]} has a counterpart in another part")
    return TypeRule(kind, ros1, f"{package}/{base}", found)


def _part(path: str) -> str:
    return path.partition(".")[0]


def _is_of(ros1: str, kind: str, part: str, path: str) -> bool:
    """Return whether a path is in a part; in a message, all are."""
    names = [name.lower() for name in PARTS[kind]]
    if names != [""] and (_part(path) not in names or "." not in path):
        raise MappingRuleError(f"{ros1}: {path} does not begin with {', '.join(names)} and a dot")
    return not part or _part(path) == part.lower()


def _inner(path: str, part: str) -> str:
    return path.partition(".")[2] if part else path


def _are_texts(values: Sequence[Any]) -> bool:
    return all(isinstance(value, str) and value for value in values)
