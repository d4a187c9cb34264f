"""Judge what stands on the parameter server against the values in force.

The server holds whatever users write. :func:`settle` decides what of it comes
into force, what is refused, and what has to be written so that the server
tells the truth again.
"""

import difflib
from typing import Any, Collection, Dict, List, Mapping, NamedTuple, Optional, Sequence

from nodekit.parameters.declaration import (
    Parameter,
    ParameterError,
    ParameterSet,
    RuleError,
    to_wire,
)


class Settled(NamedTuple):
    """The outcome of :func:`settle`.

    :param values: the snapshot that is now in force
    :param refusals: one error for each value or combination that was refused
    :param writes: by name, what the server has to be told
    """

    values: ParameterSet
    refusals: List[ParameterError]
    writes: Dict[str, Any]


def settle(
    in_force: ParameterSet,
    raw: Mapping[str, Any],
    missing: Optional[ParameterSet] = None,
    overwritten: Optional[Mapping[str, Any]] = None,
) -> Settled:
    """Bring the server's values into force as far as they are allowed.

    A refused value leaves the one in force; a rule across parameters is judged
    once all values are known and, where broken, takes back only the changes
    that it is about.

    :param in_force: the values in force so far
    :param raw: the namespace as the server holds it; other names are left alone
    :param missing: where to take values that the server lacks; the declared
        defaults where None
    :returns: the new values, the refusals and the writes
    """
    defaults = {name: item.default for name, item in in_force.declared.items()}
    fallback = missing.as_dict() if missing is not None else defaults
    current = in_force.as_dict()
    refusals: List[ParameterError] = []
    values: Dict[str, Any] = {}
    for name, parameter in in_force.declared.items():
        if name in raw and _denotes(raw[name], to_wire(current[name])):
            values[name] = current[name]  # unchanged, so not judged again
            continue
        try:
            values[name] = parameter.coerce(raw[name]) if name in raw else fallback[name]
        except ParameterError as error:
            refusals.append(error)
            values[name] = current[name]
    for name, newer in (overwritten or {}).items():
        values[name] = in_force.declared[name].coerce(newer)
    refusals += _take_back_broken(type(in_force).unjudged(values), values, current)
    settled = type(in_force).unjudged(values)
    writes = {
        name: to_wire(value)
        for name, value in values.items()
        if name not in raw or not _denotes(raw[name], to_wire(value))
    }
    return Settled(settled, refusals, writes)


def _take_back_broken(
    candidate: ParameterSet, values: Dict[str, Any], current: Mapping[str, Any]
) -> List[RuleError]:
    """Undo, in ``values``, the changes that break a rule; return the errors."""
    errors: List[RuleError] = []
    changed = {name for name in values if values[name] != current[name]}
    while True:
        broken = candidate.broken_rule(changed)
        if broken is None:
            return errors
        errors.append(broken)
        for name in changed.intersection(broken.names):
            values[name] = current[name]
        changed.difference_update(broken.names)
        candidate = candidate.unjudged(values)


def _denotes(raw: Any, value: Any) -> bool:
    """Tell whether the server's value may stay as it is: 5 may for 5.0, '5' may not."""
    if isinstance(value, list):
        return isinstance(raw, list) and len(raw) == len(value) and all(map(_denotes, raw, value))
    return bool(raw == value) and isinstance(raw, bool) == isinstance(value, bool)


def is_allowed(parameter: Parameter[Any], raw: Any) -> bool:
    """Tell whether a parameter takes a raw value.

    :param parameter: the declaration
    :param raw: the value as the server holds it
    """
    try:
        parameter.coerce(raw)
    except ParameterError:
        return False
    return True


def last_allowed(declared_in: ParameterSet, pushed: Mapping[str, Sequence[Any]]) -> Dict[str, Any]:
    """Pick, of the values pushed for each parameter, the last one that is allowed.

    :param declared_in: a set that declares the parameters
    :param pushed: raw values by parameter name, oldest first
    :returns: raw values by name; a name with no allowed value is left out
    """
    chosen: Dict[str, Any] = {}
    for name, raw_values in pushed.items():
        allowed = [raw for raw in raw_values if is_allowed(declared_in.declared[name], raw)]
        if allowed:
            chosen[name] = allowed[-1]
    return chosen


def unknown_names(
    declared: Collection[str], raw: Mapping[str, Any], exempt: Collection[str] = ()
) -> Dict[str, Optional[str]]:
    """Find names that nobody declared, most likely misspelt.

    :param declared: the declared names
    :param raw: the namespace as the server holds it
    :param exempt: other names that are known to be used
    :returns: for each unknown name the nearest known one, None if none is near
    """
    known = sorted({*declared, *exempt})
    found: Dict[str, Optional[str]] = {}
    for name in raw:
        if name not in known:
            near = difflib.get_close_matches(name.lower(), known, n=1)
            found[name] = near[0] if near else None
    return found
