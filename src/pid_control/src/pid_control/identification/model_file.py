"""Identified motor model as a YAML file: parameters for the motor node, which then simulates it."""

import math
from typing import Any, Dict

import yaml

from pid_control.identification.fit import Identification
from pid_control.identification.report import trust_in
from pid_control.identification.response import Model

#: Parameter names of the node system, by field of the model.
NAMES = {
    "gain": "system_param_K",
    "time_constant": "system_param_T",
    "dead_time": "system_dead_time",
    "dead_zone": "system_min_input",
    "limit": "system_max_speed",
}
#: Terms that the node system lacks, with a description.
_COMMENTS = {
    "offset": "the output without an input",
    "friction": "the part of the input that friction takes",
}
#: Written for a limit that the record did not reach.
_UNLIMITED = 1e9


class ModelError(ValueError):
    """Error of an invalid model file; the text gives the reason."""


def as_yaml(found: Identification, origin: str) -> str:
    """Return a model as YAML.

    :param found: the result of the identification
    :param origin: source of the record, for the comment
    """
    lines = [
        f"# Identified from {' '.join(origin.split())}.",
        *(f"# +- {sentence}." for sentence in trust_in(found)),
    ]
    for field, what in _COMMENTS.items():
        value, uncertainty = getattr(found.model, field), getattr(found.uncertainty, field)
        if value:
            lines.append(f"# {field} {value:.6g} +- {uncertainty:.2g}: {what}, not in this model.")
    for field, name in NAMES.items():
        value, uncertainty = getattr(found.model, field), getattr(found.uncertainty, field)
        if field == "dead_time":
            value = max(value, 0.0)  # negative if the input was recorded late
        note = f"+- {uncertainty:.2g}" if math.isfinite(uncertainty) else "not met"
        lines.append(f"{name}: {float(f'{min(value, _UNLIMITED):.6g}')!r}  # {note}")
    return "\n".join(lines) + "\n"


def read_model(text: str) -> Model:
    """Parse a model; dead time, dead zone and limit may be missing.

    :param text: YAML, as in :func:`as_yaml` or the course's system_params.yaml
    :raises ModelError: if the text is not a valid model
    """
    try:
        held = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ModelError(" ".join(str(error).split())) from None
    if not isinstance(held, dict):
        raise ModelError("not a mapping of names to values")
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
