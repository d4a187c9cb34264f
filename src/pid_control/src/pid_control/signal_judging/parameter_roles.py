"""Roles of a coursework's parameters, such as amplitude, by their names, and values to try."""

import contextlib
from typing import Any, Dict, Tuple, Union

Number = Union[int, float]
#: Roles of a generator's and of a process node's parameters, with parts of names of each; the first
#: that is in the name counts.
GENERATOR_ROLES: Dict[str, Tuple[str, ...]] = {
    "frequency": ("freq", "omega"),
    "rate": ("rate", "hz"),
    "amplitude": ("ampl",),
    "offset": ("offset",),
    "phase": ("phase", "shift"),
}
PROCESS_ROLES: Dict[str, Tuple[str, ...]] = {
    "rate": ("rate", "hz"),
    "phase_shift": ("phase", "shift", "angle"),
    "offset": ("offset",),
    "gain": ("ampl", "gain", "scale", "factor"),
}
#: Parts of the names of frequencies that are rates of a loop, not of the signal.
_LOOP = ("rate", "sampl", "publ", "update", "loop")
#: Factors, and summands, of a changed value by role.
_FACTORS = {"rate": 2.0, "amplitude": 1.5, "frequency": 1.25, "gain": 1.4}
_SUMMANDS = {"offset": 0.5, "phase": 0.4, "phase_shift": 0.4}
#: Factor of a value without a role.
_OTHER = 1.25
#: Summand of a phase that is an angle in rad or in degrees.
_FAR_PHASE = 20.0


def role_of(name: str, roles: Dict[str, Tuple[str, ...]]) -> str:
    """Return the role of a parameter by its name; empty if unknown.

    :param name: last part of its name
    :param roles: GENERATOR_ROLES or PROCESS_ROLES
    """
    lower = name.lower()
    for role, parts in roles.items():
        if any(part in lower.replace("sampl", "") for part in parts):  # not an amplitude
            is_loop = role == "frequency" and any(part in lower for part in _LOOP)
            return "rate" if is_loop else role
    return ""


def values_in_rad(name: str, value: float, per_unit: float, unit: str) -> Tuple[float, ...]:
    """Return the values of a parameter in rad that its name allows.

    :param name: its name
    :param value: its value, in rad or in another unit
    :param per_unit: rad per that unit
    :param unit: part of the names of parameters in that unit
    """
    last = name.rpartition("/")[2].lower()
    if unit in last:
        return (per_unit * value,)
    return (value,) if "rad" in last else (value, per_unit * value)


def is_number(value: object) -> bool:
    """Return True for a number that is not a boolean."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def changed(value: Number, role: str, is_far: bool = False) -> Number:
    """Return a value to try, of the same type.

    :param value: the present one
    :param role: role of the parameter; empty if unknown
    :param is_far: True for a value further away: 20 rad and 20 degrees both have an effect
    """
    if role in _SUMMANDS:
        new = value + (_FAR_PHASE if is_far and "phase" in role else _SUMMANDS[role])
    else:
        factor = _FACTORS.get(role, _OTHER)
        new = value * (factor * factor if is_far else factor) if value else 1.0
    if isinstance(value, int):
        return round(new) if round(new) != value else value + 1
    return float(new)


def changed_text_or_list(value: Any, role: str) -> Any:
    """Return a text of a number, or a list, with other numbers; other values unchanged.

    :param value: the present one
    :param role: role of the parameter; empty if unknown
    """
    if isinstance(value, list):
        return [changed(one, role) if is_number(one) else one for one in value]
    if isinstance(value, str):
        with contextlib.suppress(ValueError):
            return str(changed(float(value), role))
    return value
