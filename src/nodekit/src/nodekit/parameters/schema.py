"""Parameter descriptions: built and written as YAML by a node, parsed by its clients.

A description has all limits of a type of :mod:`nodekit.parameters.parameter_types`, so that a
client in another process can create the same parameter from it.
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

_TYPES: Dict[str, Type[Parameter[Any]]] = {
    "bool": BoolParameter,
    "bytes": BytesParameter,
    "int": IntParameter,
    "float": FloatParameter,
    "str": StringParameter,
    "enum": EnumParameter,
    "list": ListParameter,
}
#: Effect time of a parameter that is read once, in a node that is not managed.
AT_START = "at the next start"
#: Required keys of an entry of a description.
_NEEDED = {"name", "value", "type"}
_NUMBERS = ("minimum", "maximum", "above", "below", "step", "min_length", "max_length")


class DescriptionError(ValueError):
    """Error of a text that does not describe parameters."""


def describe(values: ParameterSet, takes_effect: str = AT_START) -> List[Dict[str, Any]]:
    """Describe each parameter of a set with its current value.

    :param values: the snapshot to describe
    :param takes_effect: when changes of parameters that are read once take effect
    :returns: for each parameter its ``name``, ``value``, ``type``, ``unit``,
        ``range`` in words, ``default``, ``help``, and when a change
        ``takes_effect``; as far as declared its
        ``minimum``, ``maximum``, ``above``, ``below``, ``step``, ``choices``,
        ``min_length``, ``max_length`` and ``element`` (``type``, ``unit``,
        ``range`` and the same again);
        ``exact``: whether these limits are complete
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
    """Return the help of a parameter, and when a change takes effect if not immediately.

    :param parameter: the parameter
    :param takes_effect: when changes of parameters that are read once take effect
    """
    return (
        f"{parameter.help}; takes effect {takes_effect}" if parameter.read_once else parameter.help
    )


def _limits(parameter: Parameter[Any]) -> Dict[str, Any]:
    """Return the limits of a parameter, and whether they are complete."""
    limits = {key: getattr(parameter, key, None) for key in _NUMBERS}
    found: Dict[str, Any] = {key: limit for key, limit in limits.items() if _is_finite(limit)}
    if isinstance(parameter, EnumParameter):
        found["choices"] = list(parameter.choices)
    parameter_class = _TYPES.get(parameter.type_name)
    exact = parameter_class is not None and type(parameter).coerce is parameter_class.coerce
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
    """Create the parameter that an entry describes.

    :param entry: an entry of the result of :func:`describe`, also by way of YAML
    :returns: a parameter that validates like the described one, or less strictly if
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
        parameter_class = _TYPES[entry["type"]]
        unit, help_ = str(entry.get("unit") or ""), str(entry.get("help") or "")
        parameter = parameter_class(entry.get("default", ()), unit=unit, help=help_, **limits)
    except (KeyError, TypeError) as error:
        raise ValueError(f"not a description of a parameter: {error}") from None
    parameter.name = str(entry.get("name", ""))
    return parameter


def _is_finite(limit: Any) -> bool:
    """Return whether a limit is a finite number; an infinite limit has no effect."""
    return type(limit) in (int, float) and -math.inf < limit < math.inf


def as_yaml(description: List[Dict[str, Any]]) -> str:
    """Return a description as YAML, without loss of precision.

    :param description: the result of :func:`describe`
    """
    return yaml_text.dump(description)


def description_in(text: str) -> List[Dict[str, Any]]:
    """Parse a description from another node.

    :param text: the result of :func:`as_yaml`
    :returns: an entry for each parameter, with at least its name, value and type
    :raises DescriptionError: if the text is not a description
    """
    try:
        entries = yaml_text.load(text)
    except ValueError:
        raise DescriptionError("the description is not valid YAML") from None
    if not isinstance(entries, list):
        raise DescriptionError("the description is not a list of parameters")
    for entry in entries:
        if not isinstance(entry, dict) or not _NEEDED.issubset(entry):
            raise DescriptionError(f"the description of a parameter is malformed: {entry!r:.80}")
    return entries
