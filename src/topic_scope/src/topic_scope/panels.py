"""From what a node says of its parameters to a panel, and from a panel's value to the node's.

The descriptions are those of the service ``~describe`` of basic_comms: a YAML list. The kinds of
parameter that they name are basic_comms' own, so that a value is judged here as the node would, and
refused in the same words.
"""

import re
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple

import yaml

from nodekit.parameters.kinds import (
    BoolParameter,
    EnumParameter,
    FloatParameter,
    IntParameter,
    Parameter,
    ParameterError,
    StringParameter,
    to_wire,
)

_INTERVAL = re.compile(r"([\[(])\s*([^,\s]+)\s*,\s*([^,\s]+)\s*([\])])\Z")
_KINDS = {"bool": "bool", "int": "int", "float": "float", "enum": "enum"}  # else: text
#: The loader of libyaml takes a tenth of the time of the one in Python.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class DescriptionError(ValueError):
    """A description that makes no sense."""


class _AnyList(Parameter[Any]):
    """A list, written as YAML; what may be in it is left to the node."""

    type_name = "list"

    @property
    def allowed(self) -> str:
        return "a list such as [1.0, 2.0]"

    def coerce(self, raw: Any) -> Any:
        if isinstance(raw, str):
            try:
                raw = yaml.load(raw, _LOADER)
            except yaml.YAMLError:
                raise self.refuse(raw) from None
        if not isinstance(raw, (list, tuple)):
            raise self.refuse(raw)
        return tuple(raw)


class Entry(NamedTuple):
    """One parameter of a panel.

    :param parameter: judges values
    :param shown: what the page is told, without the value
    """

    parameter: Parameter[Any]
    shown: Mapping[str, Any]


class Panel:
    """The parameters of one node, and the services that can be called with a button.

    :param node: namespace of the parameters
    :param text: the answer of its service ``describe``
    :param services: kind of each service, SetBool or Trigger, by name
    :raises DescriptionError: if the answer makes no sense
    """

    def __init__(self, node: str, text: str, services: Mapping[str, str]) -> None:
        self.node = node
        self.services = services
        self.entries: Dict[str, Entry] = {}
        self.values: Dict[str, Any] = {}
        for described in _read(text):
            name, entry, value = _entry(node, described)
            self.entries[name] = entry
            self.values[name] = value

    def message(self) -> Dict[str, Any]:
        """Return what the page shows."""
        return {
            "node": self.node,
            "parameters": [
                {**entry.shown, "value": self.shown_value(name)}
                for name, entry in self.entries.items()
            ],
            "services": [
                {"name": name, "kind": kind} for name, kind in sorted(self.services.items())
            ],
        }

    def shown_value(self, name: str) -> Any:
        """Return a parameter's value as the page shows it.

        :param name: name of the parameter
        """
        value = to_wire(self.values[name])
        if isinstance(value, list):
            return yaml.safe_dump(value, default_flow_style=True, width=10**6).strip()
        return value

    def judge(self, name: str, value: Any) -> Any:
        """Return the value that the node would make of one.

        :param name: name of the parameter
        :param value: as the page, or the parameter server, has it
        :raises ParameterError: if it is not allowed, in the node's own words
        """
        return self.entries[name].parameter.coerce(value)

    def follow(self, raw: Mapping[str, Any]) -> List[str]:
        """Take over what stands on the parameter server, as far as it is allowed.

        :param raw: values by name; one that is not allowed is about to be put back by the node
        :returns: names of the parameters that have changed
        """
        changed = []
        for name in self.entries:
            try:
                value = self.judge(name, raw[name])
            except (KeyError, ParameterError):
                continue
            if value != self.values[name]:
                self.values[name] = value
                changed.append(name)
        return changed


def values_in(text: str) -> Dict[str, Any]:
    """Return the values in force, by name.

    :param text: the answer of a service ``describe``
    :raises DescriptionError: if it makes no sense
    """
    return {str(described.get("name")): described.get("value") for described in _read(text)}


def _read(text: str) -> List[Dict[str, Any]]:
    try:
        described = yaml.load(text, _LOADER)
    except yaml.YAMLError:
        raise DescriptionError("the description is no YAML") from None
    if not isinstance(described, list) or not all(isinstance(one, dict) for one in described):
        raise DescriptionError("the description is no list of parameters")
    return described


def _entry(node: str, described: Mapping[str, Any]) -> Tuple[str, Entry, Any]:
    try:
        name, kind = str(described["name"]), str(described["type"])
        unit, help_, range_ = (str(described.get(key) or "") for key in ("unit", "help", "range"))
        bounds = _bounds(range_) if kind in ("int", "float") else {}
        choices = _choices(range_) if kind == "enum" else []
        parameter = _parameter(kind, described["value"], bounds, choices, unit, help_)
        parameter.name = "%s/%s" % (node, name)
        value = parameter.coerce(described["value"])
    except (KeyError, ValueError) as error:  # an unknown kind, a bad range, a value that is none
        raise DescriptionError("%s: %s" % (described.get("name"), error)) from None
    shown: Dict[str, Any] = {
        "name": name,
        "kind": _KINDS.get(kind, "string"),
        "unit": unit,
        "help": help_,
        **{end: bounds.get(end) for end in ("minimum", "maximum", "above", "below")},
        "choices": choices,
    }
    return name, Entry(parameter, shown), value


def _parameter(
    kind: str, value: Any, bounds: Dict[str, float], choices: List[str], unit: str, help_: str
) -> Parameter[Any]:
    if kind == "bool":
        return BoolParameter(value, unit=unit, help=help_)
    if kind == "int":
        return IntParameter(value, unit=unit, help=help_, **bounds)
    if kind == "float":
        return FloatParameter(value, unit=unit, help=help_, **bounds)
    if kind == "enum":
        return EnumParameter(value, choices=choices, unit=unit, help=help_)
    if kind == "list":
        return _AnyList(value, unit=unit, help=help_)
    if kind == "str":
        return StringParameter(value, unit=unit, help=help_)
    raise ValueError("there is no kind of parameter called %s" % kind)


def _bounds(text: str) -> Dict[str, float]:
    """Read an interval such as ``(0, 100]``; an infinite end is none."""
    if not text:
        return {}
    match = _INTERVAL.match(text)
    if not match:
        raise ValueError("%s is no interval" % text)
    left, low, high, right = match.groups()
    ends = {("minimum" if left == "[" else "above"): float(low)}
    ends["maximum" if right == "]" else "below"] = float(high)
    return {end: bound for end, bound in ends.items() if abs(bound) != float("inf")}


def _choices(text: str) -> List[str]:
    if not (text.startswith("{") and text.endswith("}")):
        raise ValueError("%s is no set of words" % text)
    return text[1:-1].split(", ")


def refusal_in(lines: "List[str]", node: str, name: str) -> Optional[str]:
    """Return what a node said of a parameter, the latest first.

    :param lines: warnings, oldest first
    :param node: namespace of the parameter
    :param name: its name in there
    """
    mention = re.compile(re.escape("%s/%s" % (node, name)) + r"(?![A-Za-z0-9_/])")
    return next((line for line in reversed(lines) if mention.search(line)), None)
