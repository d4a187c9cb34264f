"""A model as a YAML file: parameters of the node system, so that it can be the model."""

import math
from typing import Any, Dict

import yaml

from pid_control.identification.fit import Identified
from pid_control.identification.response import Model

#: What the parameters of the node system are called, by what they are here.
NAMES = {
    "gain": "system_param_K",
    "time_constant": "system_param_T",
    "dead_time": "system_dead_time",
    "dead_zone": "system_min_input",
    "limit": "system_max_speed",
}
#: What stands for a limit that was not met.
_UNLIMITED = 1e9


class ModelError(ValueError):
    """A file that does not hold a model; the text says why."""


def as_yaml(found: Identified, origin: str) -> str:
    """Return a model as text.

    :param found: the model, and by how much it may be wrong
    :param origin: what it was found from; one line
    """
    lines = [f"# Identified from {' '.join(origin.split())}.", "# 95 of 100 are within the +-."]
    for field, name in NAMES.items():
        value, doubt = getattr(found.model, field), getattr(found.doubt, field)
        if field == "dead_time":
            value = max(value, 0.0)  # below 0 where the input was recorded late
        note = f"+- {doubt:.2g}" if math.isfinite(doubt) else "not met"
        lines.append(f"{name}: {float(f'{min(value, _UNLIMITED):.6g}')!r}  # {note}")
    return "\n".join(lines) + "\n"


def read_model(text: str) -> Model:
    """Return the model that a text holds; dead time, dead zone and limit may be missing.

    :param text: YAML, as :func:`as_yaml` or the course's system_params.yaml has it
    :raises ModelError: if it does not hold one
    """
    try:
        held = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ModelError(" ".join(str(error).split())) from None
    if not isinstance(held, dict):
        raise ModelError("it is not a list of names and values")
    values: Dict[str, float] = {
        field: _number(held, name) for field, name in NAMES.items() if name in held
    }
    for field in ("gain", "time_constant"):
        if field not in values:
            raise ModelError(f"{NAMES[field]} is missing")
    if values["gain"] == 0.0:
        raise ModelError(f"{NAMES['gain']} must not be 0")
    for field, name in NAMES.items():
        least = -math.inf if field == "gain" else 0.0
        is_above = field in ("time_constant", "limit")
        value = values.get(field, 1.0)
        if value < least or (is_above and value == least):
            raise ModelError(f"{name} must be {'above' if is_above else 'at least'} 0: {value:g}")
    if values.get("limit", 0.0) >= _UNLIMITED:
        del values["limit"]
    return Model(**values)


def _number(held: Dict[str, Any], name: str) -> float:
    value = held[name]
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ModelError(f"{name} must be a number: {value!r}")
    return float(value)
