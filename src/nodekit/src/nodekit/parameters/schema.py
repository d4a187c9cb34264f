"""Describe parameters to programs and people, exactly enough to judge by.

A description says all that a kind of :mod:`nodekit.parameters.parameter_types` judges by,
so that a client in another process can build the same parameter of it.
"""

import math
from typing import Any, Dict, List, Mapping, Type

from nodekit.parameters import yaml_text
from nodekit.parameters.declaration import ParameterSet
from nodekit.parameters.numeric_types import FloatParameter, IntParameter
from nodekit.parameters.parameter_types import (
    BoolParameter,
    BytesParameter,
    EnumParameter,
    ListParameter,
    Parameter,
    StringParameter,
    to_wire,
)

_KINDS: Dict[str, Type[Parameter[Any]]] = {
    "bool": BoolParameter,
    "bytes": BytesParameter,
    "int": IntParameter,
    "float": FloatParameter,
    "str": StringParameter,
    "enum": EnumParameter,
    "list": ListParameter,
}
#: When what is read once takes effect, in a node that is not managed.
AT_START = "at the next start"
#: What an entry of a description always has.
_NEEDED = {"name", "value", "type"}
_NUMBERS = ("minimum", "maximum", "above", "below", "step", "min_length", "max_length")


class DescriptionError(ValueError):
    """A text that does not describe parameters."""


def describe(values: ParameterSet, takes_effect: str = AT_START) -> List[Dict[str, Any]]:
    """Describe each parameter of a set with its value in force.

    :param values: the snapshot to describe
    :param takes_effect: when changes of what is read once take effect
    :returns: for each parameter its ``name``, ``value``, ``type``, ``unit``,
        ``range`` in words, ``default``, ``help``, and when a change
        ``takes_effect``; as far as declared its
        ``minimum``, ``maximum``, ``above``, ``below``, ``step``, ``choices``,
        ``min_length``, ``max_length`` and ``element`` (``type``, ``unit``,
        ``range`` and the same again);
        ``exact``: whether it judges by no more than this
    """
    return [
        {
            "name": name,
            "value": to_wire(values.as_dict()[name]),
            "type": parameter.type_name,
            "unit": parameter.unit,
            "range": parameter.range,
            "default": to_wire(parameter.default),
            "help": help_of(parameter, takes_effect),
            "takes_effect": takes_effect if parameter.read_once else "at once",
            **_limits(parameter),
        }
        for name, parameter in values.declared.items()
    ]


def help_of(parameter: Parameter[Any], takes_effect: str) -> str:
    """Return what a parameter is for, and when a change takes effect where that is not at once.

    :param parameter: the parameter
    :param takes_effect: when changes of what is read once take effect
    """
    return (
        f"{parameter.help}; takes effect {takes_effect}" if parameter.read_once else parameter.help
    )


def _limits(parameter: Parameter[Any]) -> Dict[str, Any]:
    """Return what a parameter judges by, and whether that is all."""
    limits = {key: getattr(parameter, key, None) for key in _NUMBERS}
    found: Dict[str, Any] = {key: limit for key, limit in limits.items() if _is_finite(limit)}
    if isinstance(parameter, EnumParameter):
        found["choices"] = list(parameter.choices)
    kind = _KINDS.get(parameter.type_name)
    exact = kind is not None and type(parameter).coerce is kind.coerce
    if isinstance(parameter, ListParameter):
        element = parameter.element
        found["element"] = {
            "type": element.type_name,
            "unit": element.unit,
            "range": element.range,
            **_limits(element),
        }
        exact = exact and found["element"]["exact"]
    return {**found, "exact": exact}


def parameter_of(entry: Mapping[str, Any]) -> Parameter[Any]:
    """Build the parameter that an entry of a description is about.

    :param entry: one entry of what :func:`describe` returned, also by way of YAML
    :returns: a parameter that judges as the described one does, or by less where
        the entry is not ``exact``
    :raises ValueError: if the entry is malformed
    """
    limits = {key: entry[key] for key in _NUMBERS if key in entry}
    if not all(map(_is_finite, limits.values())):
        raise ValueError(f"limits that are not numbers: {limits}")
    try:
        if "choices" in entry:
            limits["choices"] = list(map(str, entry["choices"]))
        if "element" in entry:
            limits["element"] = parameter_of(entry["element"])
        kind = _KINDS[entry["type"]]
        unit, help_ = str(entry.get("unit") or ""), str(entry.get("help") or "")
        parameter = kind(entry.get("default", ()), unit=unit, help=help_, **limits)
    except (KeyError, TypeError) as error:
        raise ValueError(f"not a description of a parameter: {error}") from None
    parameter.name = str(entry.get("name", ""))
    return parameter


def _is_finite(limit: Any) -> bool:
    """Tell whether a limit is a finite number: an infinite one is none."""
    return type(limit) in (int, float) and -math.inf < limit < math.inf


def as_yaml(description: List[Dict[str, Any]]) -> str:
    """Return a description as YAML; all numbers come back from it as they are.

    :param description: what :func:`describe` returned
    """
    return yaml_text.dump(description)


def description_in(text: str) -> List[Dict[str, Any]]:
    """Read a description that another node has sent.

    :param text: what :func:`as_yaml` returned
    :returns: an entry for each parameter, with its name, value and type at least
    :raises DescriptionError: if it is something else
    """
    try:
        entries = yaml_text.load(text)
    except ValueError:
        raise DescriptionError("the description is not valid YAML") from None
    if not isinstance(entries, list):
        raise DescriptionError("the description is not a list of parameters")
    for entry in entries:
        if not isinstance(entry, dict) or not _NEEDED.issubset(entry):
            raise DescriptionError(f"the description of a parameter lacks something: {entry!r:.80}")
    return entries
