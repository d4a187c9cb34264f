"""Validation of raw values: each individually, then all together."""

import difflib
from typing import Any, Collection, Dict, List, Mapping, Optional, Sequence, Tuple

from nodekit.parameters.declaration import ParameterSet, Rule, Snapshot
from nodekit.parameters.errors import RuleError
from nodekit.parameters.parameter_types import MISSING, Parameter, ParameterError, plain, to_wire

#: Least similarity of the name in "did you mean", and of a misspelt name where others are in use.
_SIMILAR, _CLOSE = 0.6, 0.75


def validate_each(
    in_force: ParameterSet, raw: Mapping[str, Any], missing: Mapping[str, Any]
) -> Tuple[Dict[str, Any], List[ParameterError]]:
    """Validate each raw value individually; a rejected one keeps the current value.

    :param in_force: the current values
    :param raw: raw values by name; undeclared names are ignored
    :param missing: coerced values of the names that ``raw`` lacks
    :returns: a coerced value for each declared name, and the errors
    """
    values = in_force.as_dict()
    errors: List[ParameterError] = []
    for name, parameter in in_force.declared.items():
        try:
            values[name] = (
                _accept(parameter, raw[name], values[name]) if name in raw else missing[name]
            )
        except ParameterError as error:
            errors.append(error)
    return values, errors


def apply_rules(
    in_force: Snapshot, values: Mapping[str, Any], rules: Collection[Rule] = ()
) -> Tuple[Snapshot, List[RuleError]]:
    """Validate values together; a broken rule reverts only the changes of its parameters.

    :param in_force: the current values
    :param values: a coerced value for each declared name
    :param rules: rules in addition to those of the class
    :returns: the remaining values (the same snapshot without a change), and the errors
    """
    current, values = in_force.as_dict(), dict(values)
    changed = {name for name in values if values[name] != current[name]}
    errors: List[RuleError] = []
    while True:
        candidate = in_force.from_coerced(values)
        broken = candidate.broken_rule(changed, rules)
        if broken is None:
            return candidate if changed else in_force, errors
        errors.append(broken)
        values.update({name: current[name] for name in changed.intersection(broken.names)})
        changed.difference_update(broken.names)


def on_wire(values: ParameterSet) -> Dict[str, Any]:
    """Return values by name in the form of the parameter server.

    :param values: the values
    """
    return {name: to_wire(value) for name, value in values.as_dict().items()}


def corrections(values: ParameterSet, raw: Mapping[str, Any]) -> Dict[str, Any]:
    """Return the values by name that have to be written so that the server is correct.

    :param values: the current values
    :param raw: raw values by name on the server
    """
    wire = on_wire(values)
    return {n: value for n, value in wire.items() if n not in raw or not _denotes(raw[n], value)}


def _accept(parameter: Parameter[Any], raw: Any, current: Any) -> Any:
    """Return the coerced raw value; an unchanged value is not validated again."""
    raw = plain(raw)
    return current if _denotes(raw, to_wire(current)) else parameter.accept(raw)


def _denotes(raw: Any, value: Any) -> bool:
    """Return whether the server's value denotes the same value: 5 does for 5.0, '5' does not."""
    if isinstance(value, list):
        return isinstance(raw, list) and len(raw) == len(value) and all(map(_denotes, raw, value))
    return bool(raw == value) and isinstance(raw, bool) == isinstance(value, bool)


def last_valid(
    in_force: ParameterSet, names: Collection[str], pushed: Sequence[Tuple[str, Any]]
) -> Dict[str, Any]:
    """Return the last valid notified values of some parameters.

    :param in_force: the current values
    :param names: the parameters
    :param pushed: notified name, empty for the whole namespace, and raw value or
        MISSING, oldest first
    :returns: coerced values by name; names without a valid value are omitted
    """
    current = in_force.as_dict()
    found: Dict[str, Any] = {}
    for key, value in pushed:
        each: Dict[str, Any] = {}
        if key:
            each = {key: value}
        elif value is MISSING or isinstance(value, dict):
            each = {**dict.fromkeys(names, MISSING), **(value if value is not MISSING else {})}
        for name in each.keys() & set(names):
            parameter, raw = in_force.declared[name], each[name]
            try:
                found[name] = (
                    _accept(parameter, raw, current[name])
                    if raw is not MISSING
                    else parameter.default
                )
            except ParameterError:
                pass  # not valid either
    return found


def leaf_names(tree: Mapping[str, Any]) -> List[str]:
    """Return the names that may be intended as parameters of the node.

    Namespaces are omitted, because no parameter type accepts one: they hold the parameters of other
    nodes whose names begin with this node's name.

    :param tree: raw values by name on the server
    """
    return [name for name, value in tree.items() if not isinstance(value, dict)]


def unknown_names(
    declared: Collection[str], names: Collection[str], exempt: Collection[str] = ()
) -> Dict[str, Optional[str]]:
    """Return undeclared names, which are probably misspelt.

    :param declared: the declared names
    :param names: the names to check
    :param exempt: other names that are used; with ``*`` all names but those close to a known one
    :returns: for each unknown name the nearest known one, or None
    """
    has_others = "*" in exempt
    known = sorted({*declared, *exempt} - {"*"})
    found: Dict[str, Optional[str]] = {}
    for name in names:
        if name not in known:
            cutoff = _CLOSE if has_others else _SIMILAR
            near = difflib.get_close_matches(name.lower(), known, n=1, cutoff=cutoff)
            if near or not has_others:
                found[name] = near[0] if near else None
    return found


def unknown_name_errors(
    declared: Collection[str], changes: Mapping[str, Any]
) -> List[ParameterError]:
    """Return the errors of changes to undeclared names.

    :param declared: the declared names
    :param changes: new values by name
    """
    return [
        ParameterError(
            name,
            changes[name],
            "one that this node declares",
            f"did you mean {near}?" if near else "",
        )
        for name, near in unknown_names(declared, changes).items()
    ]
